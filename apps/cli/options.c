#include "options.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "report.h"
#include "text.h"

#define OUTPUT "Output"
#define PICTURE "Picture"
#define VIEW "View"
#define LIGHT "Light and ground, for files that bring none"
#define RENDERING "Rendering"
#define STOPPING "When to stop (whichever comes first, --samples too)"
#define PROGRAMS "Scene programs"
#define ANIMATION "Animation"
#define LIMITS "Limits; over any of them the exit code is 1"
#define MEASURES "How it is measured"
#define MACHINE "Machine"
#define EXPLAINING "What is shown"
#define TEXTS "For packagers and scripts"
#define COMMON "Every command takes"

const option_info option_table[] = {
    {OPT_OUTPUT, "output", 'o', "OUT", "{name}.png, here",
     ".png .exr .jpg .webp .apng .y4m .pfm .ppm; {name} is the input's name, {camera} the "
     "camera's, "
     "'-' standard output",
     OUTPUT, CMD_RENDER, 0, "@file", false},
    {OPT_FORMAT, "format", 0, "NAME", "png", "format for standard output, '-'", OUTPUT,
     CMD_RENDER | CMD_CONVERT, 0, "png|exr|jpg|webp|pfm|ppm|y4m", false},
    {OPT_BITS, "bits", 0, "N", "PNG 8, EXR 32", "of a channel: PNG 8 or 16, EXR 32 or 16", OUTPUT,
     CMD_RENDER | CMD_CONVERT, 0, "8|16|32", false},
    {OPT_QUALITY, "quality", 0, "N", "90", "of JPEG and WebP, 1 to 100; in WebP 100 loses nothing",
     OUTPUT, CMD_RENDER | CMD_CONVERT, 0, NULL, false},
    {OPT_CHROMA, "chroma", 0, "N", "420", "of .y4m: 420, one for four pixels, or 444, of each",
     OUTPUT, CMD_RENDER, 0, "420|444", false},
    {OPT_FORCE, "force", 0, NULL, NULL, "without -o: overwrite even a file snell did not make",
     OUTPUT, CMD_RENDER, 0, NULL, false},
    {OPT_STRIP, "strip", 0, NULL, NULL, "leave out the tag that tells how the picture was made",
     OUTPUT, CMD_RENDER | CMD_CONVERT, 0, NULL, false},
    {OPT_AOV, "aov", 0, "LIST", "scene, none",
     "layers beside the picture, as in depth,normal, or all: in the .exr, or OUT.depth.png; 'list' "
     "shows them",
     OUTPUT, CMD_PICTURE, OPTION_PICTURE, NULL, false},
    {OPT_ERROR, "error", 0, "FILE", NULL,
     "a picture of the errors; .exr and .pfm hold their numbers, .png and .ppm show them", OUTPUT,
     CMD_COMPARE, 0, "@file", false},
    {OPT_ERROR_MAP, "error-map", 0, "KIND", "flip",
     "flip, in the colours of magma, or difference: absolute, by channel", OUTPUT, CMD_COMPARE, 0,
     "flip|difference", false},

    {OPT_LAYER, "layer", 0, "NAME", "its colours",
     "of an EXR file, such as variance, or a channel, such as normal.X", PICTURE,
     CMD_COMPARE | CMD_CONVERT, 0, NULL, false},

    {OPT_SAMPLE, "sample", 0, "N", NULL, "the rays of this sample of the pixel, from 0", EXPLAINING,
     CMD_EXPLAIN, 0, NULL, false},
    {OPT_LEVELS, "levels", 0, "N", "6; all with --json",
     "show rays no deeper than this; camera ray 0", EXPLAINING, CMD_EXPLAIN, 0, NULL, false},
    {OPT_DOT, "dot", 0, NULL, NULL, "the tree as a graph for Graphviz: dot -Tsvg", EXPLAINING,
     CMD_EXPLAIN, 0, NULL, false},
    {OPT_SVG, "svg", 0, "VIEW", "side", "the rays drawn in the scene as SVG: side, top or camera",
     EXPLAINING, CMD_EXPLAIN, OPTION_OPTIONAL_VALUE, "side|top|camera", false},

    {OPT_SIZE, "size", 's', "WxH", "scene, 800x600",
     "pixels; 640x or x480 keeps the shape, 50% scales", PICTURE, CMD_PICTURE, OPTION_PICTURE, NULL,
     false},
    {OPT_SIZE, "resolution", 0, "WxH", NULL, "as --size", PICTURE, CMD_PICTURE,
     OPTION_PICTURE | OPTION_HIDDEN, NULL, false},
    {OPT_CROP, "crop", 0, "WxH+X+Y", NULL, "only this part; its pixels equal the whole picture's",
     PICTURE, CMD_PICTURE, OPTION_PICTURE, NULL, false},
    {OPT_EXPOSURE, "exposure", 0, "STOPS", "scene, 0", "twice as bright with each stop", PICTURE,
     CMD_PICTURE | CMD_COMPARE | CMD_CONVERT, OPTION_PICTURE, NULL, false},
    {OPT_TONEMAP, "tonemap", 0, "NAME", "scene, clip; neutral for models",
     "clip, reinhard, neutral, aces or agx", PICTURE, CMD_PICTURE | CMD_COMPARE | CMD_CONVERT,
     OPTION_PICTURE, "clip|reinhard|neutral|aces|agx", false},
    {OPT_WHITE_BALANCE, "white-balance", 0, "WHITE", "scene, 6504",
     "the light that is to look white: kelvin, such as 3200, or a colour", PICTURE,
     CMD_PICTURE | CMD_COMPARE | CMD_CONVERT, OPTION_PICTURE, TEXT_COLORS, true},
    {OPT_BACKGROUND, "background", 0, "BG", "scene",
     "'transparent', or a colour: '#rrggbb', a name, or linear 'r,g,b'", PICTURE, CMD_PICTURE,
     OPTION_PICTURE, "transparent|" TEXT_COLORS, true},

    {OPT_CAMERA, "camera", 'c', "NAME", "the first",
     "a camera of the file, by name or by number from 1; all: a picture from each", VIEW,
     CMD_PICTURE, OPTION_PICTURE, NULL, false},
    {OPT_VIEW, "view", 0, "DIR", NULL,
     "front, back, left, right, top, bottom, iso or AZ,EL in degrees: the whole model from there, "
     "with a margin of 5 %",
     VIEW, CMD_PICTURE, OPTION_PICTURE, "front|back|left|right|top|bottom|iso", true},
    {OPT_FOV, "fov", 0, "DEG", "scene, 40", "vertical field of view", VIEW, CMD_PICTURE,
     OPTION_PICTURE, NULL, false},
    {OPT_UP, "up", 0, "AXIS", "y; STL: z", "x, y, z, -x, -y or -z; for files that do not say", VIEW,
     CMD_PICTURE | CMD_CONVERT, OPTION_PICTURE, "x|y|z|-x|-y|-z", false},

    {OPT_LIGHT, "light", 0, "RIG", "studio",
     "studio, sky (sun and clear sky), none, or a picture of the surroundings to light with, "
     "such as roof.hdr",
     LIGHT, CMD_PICTURE, OPTION_PICTURE, "studio|sky|none", true},
    {OPT_GROUND, "ground", 0, "COLOR", "grey",
     "a floor under the model; the colour as for --background", LIGHT, CMD_PICTURE,
     OPTION_PICTURE | OPTION_OPTIONAL_VALUE, TEXT_COLORS, true},

    {OPT_INTEGRATOR, "integrator", 'i', "I", "scene, whitted", "appel, whitted, cook or path",
     RENDERING, CMD_PICTURE, OPTION_PICTURE, "appel|whitted|cook|path", false},
    {OPT_SAMPLES, "samples", 'n', "N", "scene, 16", "per pixel; 1 goes through its centre",
     RENDERING, CMD_PICTURE, OPTION_PICTURE, NULL, false},
    {OPT_SAMPLES, "spp", 0, "N", NULL, "as --samples", RENDERING, CMD_PICTURE,
     OPTION_PICTURE | OPTION_HIDDEN, NULL, false},
    {OPT_MAX_DEPTH, "max-depth", 0, "N", "scene, by integrator",
     "camera ray 0, each bounce one more", RENDERING, CMD_PICTURE, OPTION_PICTURE, NULL, false},
    {OPT_MAX_DEPTH, "depth", 0, "N", NULL, "as --max-depth", RENDERING, CMD_PICTURE,
     OPTION_PICTURE | OPTION_HIDDEN, NULL, false},
    {OPT_MIN_WEIGHT, "min-weight", 0, "W", "scene, 0.002", "drop rays that matter less than this",
     RENDERING, CMD_PICTURE, OPTION_PICTURE, NULL, false},
    {OPT_SEED, "seed", 0, "N", "scene, 0", "another choice of random numbers", RENDERING,
     CMD_PICTURE, OPTION_PICTURE, NULL, false},

    {OPT_FILTER, "filter", 0, "NAME", "scene, box",
     "box, tent, gaussian or blackman-harris: how samples make a pixel", RENDERING, CMD_PICTURE,
     OPTION_PICTURE, "box|tent|gaussian|blackman-harris", false},
    {OPT_FILTER_RADIUS, "filter-radius", 0, "PIXELS", "scene; box 0.5, tent 1, others 1.5",
     "how far it reaches", RENDERING, CMD_PICTURE, OPTION_PICTURE, NULL, false},

    {OPT_NOISE, "noise", 0, "P", "scene, none",
     "until the error of every block is under P of its mean, such as 1%, at 95 % confidence; then "
     "--samples is the most of them, by default 16384",
     STOPPING, CMD_PICTURE, OPTION_PICTURE, NULL, false},
    {OPT_TIME_LIMIT, "time-limit", 0, "T", "none",
     "such as 90s, 10m or 2h; ends after a whole round of samples, and says how many, so that -n "
     "makes it again",
     STOPPING, CMD_RENDER, 0, NULL, false},

    {OPT_SET, "set", 'D', "NAME=VALUE", NULL,
     "a value for param(\"NAME\") in a Lua scene; animation and fps of a glTF file", PROGRAMS,
     CMD_PICTURE | CMD_INFO | CMD_CONVERT, OPTION_PICTURE | OPTION_REPEATS, NULL, false},
    {OPT_ALLOW, "allow", 'I', "DIR", "the scene's own folder", "also read files in DIR", PROGRAMS,
     CMD_PICTURE | CMD_INFO | CMD_CONVERT, OPTION_PICTURE | OPTION_REPEATS, "@folder", false},
    {OPT_INPUT_FORMAT, "input-format", 0, "F", "by its content",
     "for standard input or a wrong extension", PROGRAMS, CMD_PICTURE | CMD_INFO | CMD_CONVERT,
     OPTION_PICTURE, NULL, false},

    {OPT_FRAME, "frame", 0, "N", "the first",
     "one frame of an animation (animation{}, a glTF file's), or of a turntable", ANIMATION,
     CMD_PICTURE | CMD_INFO | CMD_CONVERT, OPTION_PICTURE, NULL, false},
    {OPT_FRAMES, "frames", 0, "A..B", NULL,
     "each of these frames: in one .apng, .webp or .y4m; else in files of their own, OUT.0001.png, "
     "or where OUT has %04d",
     ANIMATION, CMD_RENDER, 0, NULL, false},
    {OPT_FPS, "fps", 0, "N", "scene, 24", "frames in a second", ANIMATION, CMD_RENDER, 0, NULL,
     false},
    {OPT_TURNTABLE, "turntable", 0, "N", NULL, "N frames, the camera going once around the model",
     ANIMATION, CMD_PICTURE, OPTION_PICTURE, NULL, false},

    {OPT_MAX_FLIP, "max-flip", 0, "X", NULL, "mean FLIP, 0 to 1", LIMITS, CMD_COMPARE, 0, NULL,
     false},
    {OPT_MAX_RMSE, "max-rmse", 0, "X", NULL, "root of the mean squared difference", LIMITS,
     CMD_COMPARE, 0, NULL, false},
    {OPT_MAX_REL_MSE, "max-rel-mse", 0, "X", NULL,
     "mean of the squared difference over A squared plus 0.01", LIMITS, CMD_COMPARE, 0, NULL,
     false},
    {OPT_MIN_PSNR, "min-psnr", 0, "DB", NULL, "peak signal-to-noise ratio, the peak being 1",
     LIMITS, CMD_COMPARE, 0, NULL, false},
    {OPT_MAX_DIFFERENCE, "max-difference", 0, "X", NULL, "largest difference of any value", LIMITS,
     CMD_COMPARE, 0, NULL, false},
    {OPT_MAX_DIFFERING, "max-differing", 0, "N", NULL,
     "pixels that differ, or a share such as 0.1%", LIMITS, CMD_COMPARE, 0, NULL, false},
    {OPT_MAX_REJECTED, "max-rejected", 0, "N", NULL, "pixels that chance does not explain (z-test)",
     LIMITS, CMD_COMPARE, 0, NULL, false},
    {OPT_PPD, "ppd", 0, "N", "67.02", "pixels per degree as the viewer of FLIP sees them", MEASURES,
     CMD_COMPARE, 0, NULL, false},
    {OPT_VARIANCE_COUNT, "variance-count", 0, "N", "many",
     "of how many values each variance is an estimate", MEASURES, CMD_COMPARE, 0, NULL, false},

    {OPT_ROUNDS, "rounds", 0, "N", "5, none after 60 s", "how often the picture is made", MEASURES,
     CMD_BENCH, 0, NULL, false},
    {OPT_THREADS, "threads", 't', "N", "the CPUs this process may use, cgroup limit included", "",
     MACHINE, CMD_PICTURE | CMD_INFO | CMD_COMPARE, 0, NULL, false},
    {OPT_MEMORY, "memory", 0, "SIZE", NULL, "stop with exit 6 before using more, such as 8G",
     MACHINE, CMD_PICTURE | CMD_INFO | CMD_COMPARE | CMD_CONVERT, 0, NULL, false},
    {OPT_ISA, "isa", 0, "NAME", "auto",
     "scalar, avx2, avx512: at most that; auto: what the CPU has; the picture is the same", MACHINE,
     CMD_PICTURE | CMD_INFO, 0, "scalar|avx2|avx512|auto", false},
    {OPT_BUILD, "build", 0, "QUALITY", "balanced",
     "fast, balanced, best: build longer so that rays are faster; the picture is the same", MACHINE,
     CMD_PICTURE | CMD_INFO, 0, "fast|balanced|best", false},
    {OPT_NO_BUILD, "no-build", 0, NULL, NULL, "only say how much memory that would take, at most",
     MACHINE, CMD_INFO, 0, NULL, false},
    {OPT_PROGRESS, "progress", 0, "WHEN", "auto", "auto, line, plain, json or none", MACHINE,
     CMD_PICTURE | CMD_COMPARE, 0, "auto|line|plain|json|none", false},

    {OPT_MAN, "man", 0, "PAGE", NULL,
     "a manual page in roff: snell, render, explain, info, compare, convert, bench, example, help "
     "or "
     "scene",
     TEXTS, CMD_HELP, 0, "snell|render|explain|info|compare|convert|bench|example|help|scene",
     false},
    {OPT_COMPLETION, "completion", 0, "SHELL", NULL, "a completion script: bash, zsh or fish",
     TEXTS, CMD_HELP, 0, "bash|zsh|fish", false},
    {OPT_LIST, "options", 0, NULL, NULL, "every option of every command, one a line", TEXTS,
     CMD_HELP, 0, NULL, false},

    {OPT_HELP, "help", 'h', NULL, NULL, "what it does and every option it takes", COMMON, CMD_ALL,
     0, NULL, false},
    {OPT_VERSION, "version", 'V', NULL, NULL,
     "version, build, CPU features, optional parts built in", COMMON, CMD_ALL, 0, NULL, false},
    {OPT_QUIET, "quiet", 'q', NULL, NULL, "warnings and errors only", COMMON, CMD_ALL, 0, NULL,
     false},
    {OPT_VERBOSE, "verbose", 'v', NULL, NULL, "say more", COMMON, CMD_ALL, 0, NULL, false},
    {OPT_JSON, "json", 0, NULL, NULL, "one JSON object on standard output, also after an error",
     COMMON, CMD_ALL, 0, NULL, false},
    {OPT_STRICT, "strict", 0, NULL, NULL, "treat a warning as an error", COMMON, CMD_ALL, 0, NULL,
     false},
    {OPT_COLOR, "color", 0, "WHEN", "auto", "auto, always or never", COMMON, CMD_ALL, 0,
     "auto|always|never", false},
};
const size_t option_table_count = sizeof option_table / sizeof option_table[0];

const command_info command_table[] = {
    {CMD_RENDER, "render", "FILE... [-o OUT]", "make a picture of each file",
     "make a picture of a model or a scene\n"
     "A file without camera or light is framed and lit for you; what was added is said in one "
     "line. Of a folder, every model in it is taken. A file with cameras is seen by its first: -c "
     "takes another, --view frames the whole "
     "model. [..] is the default; [scene] means what the scene asks for, and the value after it is "
     "used when it asks for nothing.",
     "Ctrl-C or SIGTERM: what is done is saved as OUT with '.partial' before the extension; OUT "
     "itself is never left half written.",
     "snell render shoe.glb --view 30,15 --ground --background '#fff' -s 1600x1200\n"
     "snell render shoe.glb --background transparent -o shoe.webp\n"
     "snell render shoe.glb --turntable 48 -o shoe.apng\n"
     "snell render *.stl -o 'thumbs/{name}.png' -s 256x256 --strict\n"
     "snell render glass.lua -D depth=5 -n 64 -o glass.exr\n"
     "snell render glass.lua -i path --noise 1% --time-limit 10m -o glass.exr\n"
     "snell render planets.lua --frames 1..120 -o 'out/%04d.png'\n"
     "snell solar.lua --frames 1..99 -o - --format y4m | ffmpeg -i - solar.mp4\n"
     "snell render models/ -o 'thumbs/{name}.jpg' -s 256x256\n"
     "snell render glass.lua --aov depth,normal,crypto_object -o glass.exr\n"
     "ssh server snell render - -o - < scene.lua > scene.png"},
    {CMD_EXPLAIN, "explain", "FILE X Y", "why has this pixel this colour? draw its tree of rays",
     "why has this pixel this colour?\n"
     "FILE is a scene or model, with the options that 'snell render' takes, or a picture that "
     "snell "
     "made, which says how. X and Y count from the top left, from 0. Each line of the tree is a "
     "ray "
     "or a light and begins with what it adds: they add up to the sample, and the samples to the "
     "pixel, to the last bit. Without --sample one is drawn that is near their mean.",
     NULL,
     "snell explain balls.png 400 300\n"
     "snell explain glass.lua 320 200 -i whitted -n 1 --levels 10\n"
     "snell explain glass.png 320 200 --svg > rays.svg\n"
     "snell explain glass.png 320 200 --dot | dot -Tpng > tree.png\n"
     "snell explain glass.png 320 200 --json | jq '.rays[0].hit.shape'"},
    {CMD_INFO, "info", "FILE...", "what is in this model, scene or picture",
     "what is in a model, a scene or a picture\n"
     "Of a model or scene: format, counts, bounds, cameras, lights, materials, the values that it "
     "takes from -D. Of a picture: its size, of floats the least and the largest value, and the "
     "command that makes it again.",
     NULL, "snell info duck.glb\nsnell info duck.png\nsnell info balls.lua --json"},
    {CMD_COMPARE, "compare", "A B", "how far apart are two pictures",
     "say how far two pictures are apart\n"
     "A is the reference. Without a limit every difference counts: exit 0 says equal, 1 different. "
     "Files for screens (PNG, JPEG, WebP, PPM) are compared as shown, by their sRGB values from 0 "
     "to 1, "
     "and "
     "two of floats (EXR, PFM, HDR) in linear light. A file of floats is first shown where the "
     "other "
     "is for screens, and both with --exposure or --tonemap. FLIP says how much somebody sees who "
     "flips between the two, from 0 to 1; in linear light it is HDR-FLIP.",
     "Where an EXR has a layer 'variance' (of each pixel's mean), each difference is also held "
     "against "
     "what chance explains: 5 % of all values should be beyond the 5 % level, and in 99 of 100 "
     "comparisons no pixel rejected. --variance-count 4 says that each variance comes from 4 "
     "values.",
     "snell compare reference.png new.png\n"
     "snell compare reference.exr new.exr --max-flip 0.01 --error difference.png\n"
     "snell compare -q a.png b.png && echo equal\n"
     "snell compare long.exr short.exr --max-rejected 0\n"
     "snell compare a.png b.png --json | jq .rmse"},
    {CMD_CONVERT, "convert", "A B", "a picture or a scene in another form; no new rendering",
     "write a picture or a scene in another form\n"
     "B's extension decides. Where A is a scene or model, B may be a .snell, a compiled scene: one "
     "file with "
     "all that is in it, textures and meshes too, read like any other, and faster, by this version "
     "of snell "
     "alone, so keep A; or a .lua, a program in the scene language, with its meshes and images in "
     "a "
     "folder beside it. The picture is the same to the bit. Values (-D), --frame and --up are "
     "settled by "
     "it.\n"
     "Otherwise A is a PNG, JPEG, WebP, PPM, EXR, PFM or HDR, and B a .png, .exr, .jpg, .webp, "
     ".pfm or "
     ".ppm; '-' is "
     "standard input or "
     "output. From floats to 8 bits the picture is exposed and mapped as its "
     "scene asks, if snell made it. Its tag is kept: 'snell info B' says how to make it again.",
     "B is the old file or the complete new one, never half written.",
     "snell convert glass.exr glass.png --exposure 1.5 --tonemap neutral\n"
     "snell convert render.exr depth.png --layer depth --exposure -3\n"
     "snell render my.lua -o - --format exr | snell convert - my.png\n"
     "snell convert city.pbrt city.snell && snell city.snell\n"
     "snell convert balls.nff balls.lua\n"
     "snell convert solar-system.lua day40.snell --frame 40"},
    {CMD_BENCH, "bench", "[FILE]", "where the time goes; without FILE, this machine's score",
     "say where the time of a picture goes\n"
     "FILE is made into a picture several times, with the options that 'snell render' takes; "
     "nothing is "
     "written. The table tells seconds by phase, rays by kind, tests a ray and memory; lines below "
     "it "
     "what is unusual. CPU time is that of all threads and of the import helper. Without FILE: the "
     "rays per second of a built-in scene, on one thread and on all.",
     NULL,
     "snell bench duck.glb\n"
     "snell bench glass.lua -i path -n 16 -s 50% --rounds 11\n"
     "snell bench city.glb --json | jq .cpu_seconds.build.median\n"
     "snell bench"},
    {CMD_EXAMPLE, "example", "[NAME]", "print a scene to start from; without NAME, list them",
     "print a scene to start from\n"
     "Each is a short Lua program with comments; without NAME, they are listed.",
     NULL, "snell example hello > my.lua\nsnell my.lua"},
    {CMD_HELP, "help", "[TOPIC]", "explain a command, a topic or a name",
     "explain a command, a topic, or any one name of the scene language", NULL,
     "snell help materials\nsnell help dielectric\nsnell help --completion bash"},
};
const size_t command_table_count = sizeof command_table / sizeof command_table[0];

bool option_belongs(const option_info *info, const command_info *command) {
    return command == NULL ? info->commands == CMD_ALL : (info->commands & command->bit) != 0;
}

const option_info *option_find(const char *name, size_t length) {
    for (size_t i = 0; i < option_table_count; i++) {
        const char *other = option_table[i].name;
        if (strlen(other) == length && strncmp(name, other, length) == 0) return &option_table[i];
    }
    return NULL;
}

static const option_info *option_find_letter(char letter) {
    for (size_t i = 0; i < option_table_count; i++) {
        if (option_table[i].letter == letter) return &option_table[i];
    }
    return NULL;
}

const command_info *command_find(const char *name) {
    for (size_t i = 0; i < command_table_count; i++) {
        if (strcmp(command_table[i].name, name) == 0) return &command_table[i];
    }
    return NULL;
}

static bool needs_value(const option_info *info) {
    return info->metavar != NULL && (info->flags & OPTION_OPTIONAL_VALUE) == 0;
}

/* Whether the argument takes the next one as its value. */
static bool eats_next(const char *argument) {
    if (argument[0] != '-' || argument[1] == '\0') return false;
    if (argument[1] == '-') {
        const option_info *info = option_find(argument + 2, strlen(argument + 2));
        return info != NULL && needs_value(info);
    }
    for (const char *c = argument + 1; *c != '\0'; c++) {
        const option_info *info = option_find_letter(*c);
        if (info == NULL) return false;
        if (needs_value(info)) return c[1] == '\0';
    }
    return false;
}

/* The first word that is no option names the command; one with '.' or '/' in it is a file to
 * render. Returns its index, argc when there is none. */
static int find_command_word(int argc, char **argv) {
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--") == 0) return i + 1 < argc ? i + 1 : argc;
        if (argv[i][0] != '-' || argv[i][1] == '\0') return i;
        if (eats_next(argv[i])) i++;
    }
    return argc;
}

static int unknown_command(const char *word) {
    const char *names[16];
    size_t count = 0;
    for (size_t i = 0; i < command_table_count; i++) names[count++] = command_table[i].name;
    const char *near = text_closest(word, names, count);
    char hint[160];
    if (near != NULL)
        snprintf(hint, sizeof hint, "did you mean 'snell %s'?", near);
    else
        snprintf(hint, sizeof hint, "'snell --help' lists them; a file here is ./%.80s", word);
    return report_usage(hint, "there is no command '%s'", word);
}

static int unknown_option(const command_info *command, const char *name, size_t length) {
    char word[64], hint[160] = "'snell --help' lists what there is";
    const char *names[OPT_COUNT + 8];
    size_t count = 0;
    snprintf(word, sizeof word, "%.*s", (int)length, name);
    const char *label = command == NULL ? "snell" : command->name;
    if (command != NULL)
        snprintf(hint, sizeof hint, "'snell %s --help' lists what it takes", label);
    for (size_t i = 0; i < option_table_count; i++) {
        if (option_belongs(&option_table[i], command)) names[count++] = option_table[i].name;
    }
    const char *near = text_closest(word, names, count);
    const option_info *elsewhere = option_find(name, length);
    if (elsewhere != NULL && near != NULL) {
        snprintf(hint, sizeof hint, "did you mean '--%s'?", near);
        return report_usage(hint, "%s takes no option '--%s'", label, word);
    }
    if (elsewhere != NULL) {
        for (size_t i = 0; i < command_table_count; i++) {
            if ((elsewhere->commands & command_table[i].bit) != 0) {
                snprintf(hint, sizeof hint, "it belongs to 'snell %s'", command_table[i].name);
                break;
            }
        }
        return report_usage(hint, "%s takes no option '--%s'", label, word);
    }
    if (near != NULL) snprintf(hint, sizeof hint, "did you mean '--%s'?", near);
    return report_usage(hint, "unknown option '--%s'", word);
}

static void list_append(string_list *list, const char *text) { list->items[list->count++] = text; }

static int take_value(options *o, const option_info *info, const char *value) {
    bool alone = *value == '\0' && (info->flags & OPTION_OPTIONAL_VALUE) != 0;
    if (info->values != NULL && info->values[0] != '@' && !info->open && !alone &&
        !text_choice_has(info->values, value)) {
        char hint[160], near[48], list[120];
        text_choice_list(info->values, list, sizeof list);
        if (text_choice_closest(info->values, value, near, sizeof near)) {
            snprintf(hint, sizeof hint, "did you mean '%s'?", near);
        } else {
            snprintf(hint, sizeof hint, "it is one of: %s", list);
        }
        return report_usage(hint, "--%s: there is no '%s'", info->name, value);
    }
    if (info->id == OPT_SET) list_append(&o->set, value);
    if (info->id == OPT_ALLOW) list_append(&o->allow, value);
    o->value[info->id] = value;
    o->given[info->id]++;
    return EXIT_DONE;
}

static int missing_value(const option_info *info) {
    char hint[120];
    snprintf(hint, sizeof hint, "such as --%s %s", info->name, info->metavar);
    return report_usage(hint, "--%s needs a value", info->name);
}

/* A value that may be left out follows '=': "--ground=" has none, and "--ground red" would take red
 * for a file. */
static int check_optional(const option_info *info, const char *value, const char *next) {
    char hint[120];
    snell_vec3 color;
    if (value != NULL && *value == '\0') {
        snprintf(hint, sizeof hint, "--%s alone takes the default", info->name);
        return report_usage(hint, "--%s= has no value", info->name);
    }
    if (value != NULL || next == NULL || !text_color(next, &color) || access(next, F_OK) == 0) {
        return EXIT_DONE;
    }
    snprintf(hint, sizeof hint, "did you mean --%s=%.64s?", info->name, next);
    return report_usage(hint, "--%s: its value follows '='", info->name);
}

static int parse_long(options *o, const char *text, const char *next) {
    size_t length = strcspn(text, "=");
    const char *value = text[length] == '=' ? text + length + 1 : NULL;
    const option_info *info = option_find(text, length);
    if (info == NULL || !option_belongs(info, o->command)) {
        return unknown_option(o->command, text, length);
    }
    if (info->metavar == NULL && value != NULL) {
        return report_usage(NULL, "--%s takes no value", info->name);
    }
    if (value == NULL && needs_value(info)) {
        if (next == NULL) return missing_value(info);
        value = next;
    }
    if (info->metavar != NULL && !needs_value(info)) {
        int code = check_optional(info, value, next);
        if (code != EXIT_DONE) return code;
    }
    return take_value(o, info, value == NULL ? "" : value);
}

static int parse_letters(options *o, const char *letters, const char *next) {
    for (const char *c = letters; *c != '\0'; c++) {
        const option_info *info = option_find_letter(*c);
        if (info == NULL || !option_belongs(info, o->command)) {
            const char *label = o->command == NULL ? "snell" : o->command->name;
            return report_usage("a file whose name begins with '-' is written ./-name",
                                "%s takes no option '-%c'", label, *c);
        }
        if (needs_value(info)) {
            const char *value = c[1] != '\0' ? c + 1 : next;
            if (value == NULL) return missing_value(info);
            return take_value(o, info, value[0] == '=' ? value + 1 : value);
        }
        int code = take_value(o, info, "");
        if (code != EXIT_DONE) return code;
    }
    return EXIT_DONE;
}

static bool allocate_lists(options *o, int argc) {
    size_t size = sizeof(char *) * (size_t)(argc + 1);
    o->set.items = malloc(size);
    o->allow.items = malloc(size);
    o->operands.items = malloc(size);
    return o->set.items != NULL && o->allow.items != NULL && o->operands.items != NULL;
}

/* --json, --color and --quiet count even when an earlier option is wrong. */
static void parse_ahead(int argc, char **argv, options *o) {
    for (int i = 1; i < argc && strcmp(argv[i], "--") != 0; i++) {
        if (strcmp(argv[i], "--json") == 0) o->value[OPT_JSON] = "";
        if (strcmp(argv[i], "--color=never") == 0) o->value[OPT_COLOR] = "never";
        if (eats_next(argv[i])) i++;
    }
    report_setup(o);
}

int options_parse(int argc, char **argv, options *o) {
    memset(o, 0, sizeof *o);
    if (argc < 1 || !allocate_lists(o, argc)) {
        return report_error(EXIT_MEMORY, NULL, "out of memory");
    }
    parse_ahead(argc, argv, o);
    int word = find_command_word(argc, argv);
    if (word < argc) {
        o->command = command_find(argv[word]);
        if (o->command == NULL) {
            bool file = strpbrk(argv[word], "./") != NULL || strcmp(argv[word], "-") == 0;
            if (!file) return unknown_command(argv[word]);
            o->command = command_find("render");
            word = 0;
        }
    }
    bool ended = false;
    for (int i = 1; i < argc; i++) {
        char *at = argv[i];
        const char *next = i + 1 < argc ? argv[i + 1] : NULL;
        int code = EXIT_DONE;
        if (i == word) continue;
        if (ended || at[0] != '-' || at[1] == '\0') {
            list_append(&o->operands, at);
        } else if (strcmp(at, "--") == 0) {
            ended = true;
        } else {
            code = at[1] == '-' ? parse_long(o, at + 2, next) : parse_letters(o, at + 1, next);
            if (eats_next(at)) i++;
        }
        if (code != EXIT_DONE) return code;
    }
    report_setup(o);
    return EXIT_DONE;
}

static bool copy_list(const string_list *from, size_t more, string_list *to) {
    to->items = malloc((from->count + more + 1) * sizeof *to->items);
    if (to->items == NULL) return false;
    memcpy(to->items, from->items, from->count * sizeof *to->items);
    return true;
}

int options_with(const options *o, const char *const *words, size_t count, options *out) {
    *out = *o;
    bool set = copy_list(&o->set, count, &out->set),
         allow = copy_list(&o->allow, count, &out->allow),
         operands = copy_list(&o->operands, 0, &out->operands);
    if (!set || !allow || !operands) return report_error(EXIT_MEMORY, NULL, "out of memory");
    for (size_t i = 0; i < count; i++) {
        int code = parse_long(out, words[i] + 2, NULL);
        if (code != EXIT_DONE) return code;
    }
    return EXIT_DONE;
}

void options_free(options *o) {
    free(o->set.items);
    free(o->allow.items);
    free(o->operands.items);
}
