/* What `snell help` explains in words; tables of types are added where a category is named. */
#include "commands.h"

static const char scene_text[] =
    "A scene is a Lua 5.4 program in a sandbox: no files but its own folder's, no clock,\n"
    "no chance. The same program gives the same scene on every machine. Each call adds\n"
    "something; a shape is drawn where it is made.\n"
    "\n"
    "  camera { from = {0, 2, 8}, at = {0, 1, 0}, fov = 40 }\n"
    "  background { color = {0.2, 0.3, 0.5} }\n"
    "  light.point { position = {-3, 5, 4}, intensity = 100 }\n"
    "  local red = material.lambert { color = {0.8, 0.2, 0.1} }\n"
    "  sphere { center = {0, 1, 0}, radius = 1, material = red }\n"
    "  plane { point = {0, 0, 0}, normal = {0, 1, 0} }\n"
    "\n"
    "Metres, seconds, degrees; +Y is up; a camera looks along its -Z. A colour is {r,g,b}\n"
    "or one number, linear, or \"#rrggbb\", sRGB. An unknown name, a wrong type and a value\n"
    "out of range are errors with file and line.\n"
    "\n"
    "  render { width = 800, height = 600, samples = 16, max_depth = 10 }\n"
    "                                   settings; the command line beats them\n"
    "  param(\"depth\", 4, \"what for\")   a value that -D depth=5 sets; 'snell info' lists them\n"
    "  model { file = \"shoe.glb\" }      another file's content\n"
    "  transform.translate{x,y,z}, .rotate{axis=, angle=}, .scale(s); a * b applies b first\n"
    "\n"
    "'snell example hello' prints a whole one. Settings, for 'snell help NAME':";

static const char integrators_text[] =
    "  appel     Appel 1968: what the camera sees, lit by lights that nothing hides;\n"
    "            no reflections\n"
    "  whitted   Whitted 1980: mirrors and glass send on rays of their own, up to\n"
    "            --max-depth; matt surfaces see the lights\n"
    "\n"
    "Both are exact: every ray that matters more than --min-weight is followed, and what\n"
    "was dropped is reported (--json, dropped_weight).";

static const char tonemaps_text[] =
    "  clip      what is brighter than 1 is cut off\n"
    "  reinhard  Reinhard 2002: c / (1 + c), on the luminance\n"
    "  neutral   Khronos PBR Neutral: colours up to 0.8 stay as they are, highlights\n"
    "            roll off; the default for models\n"
    "\n"
    "--exposure comes before, in stops. EXR and PFM are never tone-mapped.";

static const char exit_text[] =
    "  0   done\n"
    "  1   some of several files failed\n"
    "  2   wrong command line\n"
    "  3   wrong input: a file's content, or what a scene program asks for\n"
    "  4   unsupported: understood, but this version or build cannot do it\n"
    "  5   a file cannot be read or written\n"
    "  6   out of memory, or over --memory\n"
    "  7   a fault in snell itself: please report\n"
    "  130, 143   ended by Ctrl-C or SIGTERM; what was done is in OUT.partial.EXT\n"
    "\n"
    "With --json standard output has one object, also after an error:\n"
    "  {\"schema\": 1, \"error\": {\"status\", \"message\", \"hint\", \"file\", \"line\", "
    "\"column\",\n"
    "  \"exit\"}, \"warnings\": [...]}; of several files, \"files\" is a list of such objects.";

static const char environment_text[] =
    "  SNELL_THREADS   as --threads\n"
    "  SNELL_ISA       as --isa\n"
    "  NO_COLOR        when set and not empty, no colours (--color always beats it)\n"
    "  TMPDIR          where standard input is kept while it is read\n"
    "\n"
    "The command line beats the environment. Another SNELL_* gets a warning. There is no\n"
    "configuration file.";

const help_topic help_topics[] = {
    {"formats", NULL, "the files that are read and written", NULL},
    {"scene", "setting", "the scene language", scene_text},
    {"materials", "material", "how surfaces scatter light", NULL},
    {"lights", "light", "where light comes from", NULL},
    {"shapes", "shape", "what there is to see", NULL},
    {"cameras", "camera", "how rays start", NULL},
    {"textures", "texture", "what varies over a surface", NULL},
    {"integrators", NULL, "how light is followed", integrators_text},
    {"tonemaps", NULL, "from radiance to a screen's colours", tonemaps_text},
    {"exit", NULL, "what the exit code says", exit_text},
    {"environment", NULL, "variables that snell reads", environment_text},
};
const size_t help_topic_count = sizeof help_topics / sizeof help_topics[0];
