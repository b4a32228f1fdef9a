/* What `snell help` explains in words; tables of types are added where a category is named. */
#include <string.h>

#include "commands.h"
#include "text.h"

static const char scene_text[] =
    "A scene is a Lua 5.4 program in a sandbox: no files but its own folder's, no\n"
    "clock, no chance. The same program gives the same scene on every machine. Each\n"
    "call adds something to it.\n"
    "\n"
    "  camera { from = {0, 2, 8}, at = {0, 1, 0}, fov = 40 }\n"
    "  background { color = {0.2, 0.3, 0.5} }\n"
    "  light.point { position = {-3, 5, 4}, intensity = 100 }\n"
    "  local red = material.lambert { color = {0.8, 0.2, 0.1} }\n"
    "  sphere { center = {0, 1, 0}, radius = 1, material = red }\n"
    "  plane { point = {0, 0, 0}, normal = {0, 1, 0} }\n"
    "\n"
    "Settings: each at most once; the command line beats them\n"
    "  render { width = 800, height = 600, samples = 16, max_depth = 10 }\n"
    "  background { color = 0.5 }     what a ray that meets nothing sees\n"
    "  ambient { color = 0.05 }       light that is everywhere\n"
    "\n"
    "Cameras: the first one is used, --camera takes another\n"
    "  camera { name = \"front\", from = {0, 2, 8}, at = {0, 1, 0}, fov = 40 }\n"
    "  camera { view = {30, 12}, of = shoe }     frames a shape, a group or a model\n"
    "\n"
    "What is seen\n"
    "  sphere { .. }, plane, box, disk, quad     'snell help shapes' lists all\n"
    "  triangle { {..}, {..}, {..} }             by its corners\n"
    "  mesh { file = \"bunny.ply\" }               or positions = {..}, indices = {..}\n"
    "  model { file = \"shoe.glb\" }               what another file draws\n"
    "  include \"table.lua\"                       all of it: cameras and lights too\n"
    "  union { a, b, .. }                        also intersection, difference\n"
    "  group { a, b, .. }                        several shapes as one\n"
    "  instance { a, transform = t }             a at another place\n"
    "\n"
    "Each of these but include takes material, transform and name, and motion. A\n"
    "shape is drawn once, where it is made, unless a group or an instance takes it:\n"
    "then each of these draws it, and it is not drawn by itself. All but a plane\n"
    "have .bounds with min, max, center and size.\n"
    "\n"
    "How it looks\n"
    "  material.lambert { .. }                   'snell help materials'\n"
    "  light.point { .. }                        'snell help lights'\n"
    "  texture.image { file = \"wood.png\" }       PNG, JPEG, WebP, HDR, EXR, PFM\n"
    "  texture.checker { a, b, size = 1 }        two colours; also gradient, noise\n"
    "\n"
    "A texture may stand wherever a colour or a number varies over a surface.\n"
    "\n"
    "Where it is; a * b applies b first\n"
    "  transform.translate {x, y, z}\n"
    "  transform.rotate { axis = {0, 1, 0}, angle = 30 }\n"
    "  transform.scale(2)\n"
    "  transform.look_at { from = {..}, at = {..} }\n"
    "  transform.matrix { {1, 0.5, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0} }\n"
    "\n"
    "In motion\n"
    "  animation { fps = 24, first = 1, last = 120 }    'snell help motion'\n"
    "\n"
    "To and from the command line\n"
    "  param(\"depth\", 4, \"what for\")      a value that -D depth=5 sets\n"
    "  param.file(\"model\", \"shoe.glb\")    a file's name; 'snell info' lists them all\n"
    "  print(\"depth is\", depth)           a line on standard error\n"
    "\n"
    "Metres and degrees; +Y is up; a camera looks along its -Z. A colour is {r,g,b}\n"
    "or one number, linear, or \"#rrggbb\", sRGB. An unknown name, a wrong type and a\n"
    "value out of range are errors with file and line. 'snell help NAME' explains\n"
    "each of these words; 'snell example hello' prints a whole scene.";

static const char settings_text[] =
    "A scene gives each at most once. The command line beats them, they beat an\n"
    "imported file, which beats the default.";

static const char materials_text[] =
    "  local red = material.lambert { color = {0.8, 0.2, 0.1}, name = \"red\" }\n"
    "  sphere { radius = 1, material = red }\n"
    "\n"
    "A texture may stand for a colour or a number that varies over the surface. What\n"
    "has no material is matt grey. Every material takes name.";

static const char lights_text[] =
    "  light.point { position = {-3, 5, 4}, intensity = 100 }    watts per steradian\n"
    "\n"
    "  light.quad { center = {0, 3, 0}, at = {0, 0, 0}, width = 1, radiance = 12 }\n"
    "  light.environment { file = \"sky.hdr\", rotate = 90 }\n"
    "  light.environment { sky = { sun = {1, 1, 0.5}, turbidity = 3 } }\n"
    "\n"
    "quad, disk and sphere are surfaces that shine; so is every shape whose material\n"
    "has emission. appel and whitted light from the middle of them, with hard\n"
    "shadows; cook and path from all of the surface. Those with 'power' take it in\n"
    "place of radiance or intensity. visible = false hides a light from the camera.\n"
    "\n"
    "light.environment also takes\n"
    "  file          a picture of the surroundings: longitude by latitude, its\n"
    "                middle towards -Z; PNG, JPEG, HDR, EXR or PFM. radiance\n"
    "                multiplies it\n"
    "  sky           the fields of light.sky: a clear sky, and its sun as a light of\n"
    "                its own. By day all is bright: --exposure -5 or so\n"
    "\n"
    "Several environments add up; where a ray sees one, it does not see the\n"
    "background. Every light takes name. A scene without light, emission, ambient\n"
    "light and background is lit by the studio.";

static const char shapes_text[] =
    "  sphere { center = {0, 1, 0}, radius = 1, material = red, name = \"ball\" }\n"
    "\n"
    "Every shape takes\n"
    "  material      what material.NAME { .. } gave; none: matt grey\n"
    "  transform     what transform.NAME gave; none: as it is described\n"
    "  motion        how it moves: 'snell help motion'\n"
    "  name          a text, for 'snell info' and messages\n"
    "\n"
    "There are also triangle, model, include, group and instance: 'snell help\n"
    "group'; and union, intersection and difference: 'snell help union'. A shape is\n"
    "drawn once, where it is made, unless one of these takes it. All but a plane\n"
    "have .bounds with min, max, center and size: s.bounds.max[2] is the top of s.";

static const char cameras_text[] =
    "  camera { from = {0, 2, 8}, at = {0, 1, 0}, fov = 40 }\n"
    "  camera { view = {30, 12}, of = shoe, name = \"side\" }\n"
    "\n"
    "Besides the fields of its kind a camera takes\n"
    "  kind          word: one of those below                          [perspective]\n"
    "  name          a text: --camera NAME chooses by it\n"
    "  view, of      instead of from and at: {azimuth, elevation} in degrees, where\n"
    "                {0, 0} is the front, of a shape, group or model that then fills\n"
    "                the picture\n"
    "\n"
    "With lens_radius a camera has depth of field; where something moves, its\n"
    "shutter blurs it. Parallel rays (orthographic) begin level with 'from': put it\n"
    "well back.\n"
    "\n"
    "The first camera is the default one. A scene without any is framed as a model\n"
    "is.";

static const char motion_text[] =
    "  animation { fps = 24, first = 1, last = 120 }     sets the globals time and frame\n"
    "  sphere { motion = { {time = 0, transform = a}, {time = 0.5, transform = b} } }\n"
    "  group { .., motion = function(t) return transform.translate {0, 2 * t, 0} end }\n"
    "\n"
    "Every shape, group, instance and model, and the camera, takes motion: keys in\n"
    "the order of their times, or a function of the time. Times are seconds; frame f\n"
    "is at time (f - 1) / fps. Motion comes after the transform of the same table.\n"
    "Between keys, places and sizes go straight and turns take the shorter arc, so\n"
    "keys are less than half a turn apart: between 0 and 360 degrees nothing turns,\n"
    "and there is a warning. A wheel takes a function, or keys in between. Before the\n"
    "first key and after the last nothing moves.\n"
    "\n"
    "  mesh { indices = {..}, keys = { {time = 0, positions = {..}, normals = {..}},\n"
    "                                  {time = 0.02, positions = {..}, ..}, .. } }\n"
    "\n"
    "A mesh deforms: every vertex goes straight from key to key. All keys have as\n"
    "many positions, and normals or none.\n"
    "\n"
    "A camera's shutter = {open, close} counts in frames from the frame's own time;\n"
    "{0, 0.5} is the usual half. shutter = {0, 0} freezes everything.\n"
    "\n"
    "The program runs once for each frame: what reads 'time' or 'frame' differs\n"
    "between frames, what has motion also blurs within one. --frame N makes one\n"
    "frame, --frames A..B each in a file of its own.\n"
    "\n"
    "A glTF file with animations has frames of its own: snell fox.glb --frame 6,\n"
    "with -D animation=NAME for another than the first and -D fps=30 for 30 a second\n"
    "in place of 24. Without --frame it rests. snell info fox.glb lists them.";

static const char textures_text[] =
    "  texture.image { file = \"wood.png\", encoding = \"srgb\" }     PNG or JPEG\n"
    "  texture.checker { {0.9, 0.9, 0.9}, {0.1, 0.1, 0.1}, size = 0.5 }\n"
    "\n"
    "  local tiles = texture.checker { 0.9, 0.1 }\n"
    "  plane { material = material.lambert { color = tiles } }\n"
    "\n"
    "A texture may stand wherever a colour or a number varies over a surface. Every\n"
    "texture takes name. Images may be Radiance HDR, OpenEXR and PFM too.";

static const char group_text[] =
    "  local wheel = group { disk { .. }, sphere { .. }, name = \"wheel\" }\n"
    "  for i = 0, 3 do\n"
    "    instance { wheel, transform = transform.translate {i, 0, 0} }\n"
    "  end\n"
    "\n"
    "group { a, b, .. } makes one of several shapes. It takes\n"
    "  material      for those of its parts that have none\n"
    "  transform     moves all of them\n"
    "  name          stands before their names: wheel/rim\n"
    "\n"
    "A shape that a group or an instance takes is no longer drawn by itself. The\n"
    "group is drawn once, where it is made, unless an instance or another group\n"
    "takes it: the four wheels above are drawn, the first one is not. Groups nest\n"
    "8 deep; a scene may draw 4 billion shapes, since groups are kept once.";

static const char instance_text[] =
    "  local chair = model { file = \"chair.glb\" }\n"
    "  instance { chair }\n"
    "  instance { chair, transform = transform.translate {2, 0, 0}, material = red }\n"
    "\n"
    "instance { a } draws the shape, group or model a: as often as you like, in the\n"
    "memory of one. It takes\n"
    "  material      in place of those of its parts\n"
    "  transform     where it is, after a's own\n"
    "  name          stands before their names\n"
    "\n"
    "Once an instance has taken a, a is not drawn by itself; the first line above\n"
    "draws nothing, the next two a chair each.";

static const char solid_text[] =
    "  difference {\n"
    "    box { min = {-1, 0, -1}, max = {1, 2, 1}, material = red },\n"
    "    sphere { center = {0, 2, 0}, radius = 0.8, material = gold },\n"
    "  }\n"
    "  intersection { sphere { center = {0, 0, -4}, radius = 5 },\n"
    "                 sphere { center = {0, 0, 4}, radius = 5 }, material = glass }\n"
    "\n"
    "  union         all that any of the shapes has\n"
    "  intersection  what all of them have in common\n"
    "  difference    the first, less all others\n"
    "\n"
    "They take closed shapes, such as sphere, box, torus, a capped cylinder and a mesh\n"
    "without holes; planes, as all that lies behind them; groups, as the union of\n"
    "their shapes; and each other: at most 1024 shapes. They also take\n"
    "  material      for those of the shapes that have none\n"
    "  transform, motion, name\n"
    "\n"
    "A face has the material of the shape that it comes from; where two coincide, of\n"
    "the first. A solid of glass is filled with one medium, that of the first of its\n"
    "shapes whose material is a dielectric. Textures by the point, not by u and v,\n"
    "run through all of a solid. One that shines is no light that cook and whitted\n"
    "sample: only rays meet it.";

static const char model_text[] =
    "  local shoe = model { file = \"shoe.glb\", material = red }\n"
    "  camera { view = {30, 12}, of = shoe }\n"
    "\n"
    "model draws what is in another file: any format of 'snell help formats', scenes\n"
    "too.\n"
    "  file          its path from the scene's folder, or --allow       required\n"
    "  material      in place of its own\n"
    "  transform     where it is\n"
    "  name          stands before the names of its parts\n"
    "  camera        boolean: also take its cameras                          [false]\n"
    "  lights        boolean: also take its lights                           [false]\n"
    "  animation     of a glTF file: a name, a number as text, or all        [first]\n"
    "\n"
    "Where the scene has animation{}, an animated model follows its clock; else it\n"
    "rests, unless its animation is named.\n"
    "\n"
    "It is a group: an instance may take it, and it has .bounds. mesh { file = }\n"
    "does the same without cameras and lights, and with smooth = false leaves\n"
    "the faces of a PLY or OBJ without normals flat.";

static const char include_text[] =
    "  include \"table.lua\"\n"
    "\n"
    "Everything that is in the file, as if it stood here: shapes, cameras, lights\n"
    "and settings. Its local names stay its own. It gives a group, as model does.";

static const char param_text[] =
    "  local depth = param(\"depth\", 4, \"levels of spheres\")\n"
    "  local file = param.file(\"model\", \"shoe.glb\", \"what to photograph\")\n"
    "  local shoe = model { file = file }\n"
    "\n"
    "  snell scene.lua -D depth=5 -D model=boot.glb\n"
    "\n"
    "param(NAME, DEFAULT, HELP) gives the value of -D NAME=VALUE, else the default.\n"
    "The default is a number, a text, true or false, and the value must be of its\n"
    "kind. 'snell info scene.lua' lists all; a -D that the scene does not ask for is\n"
    "an error.";

static const char transform_text[] =
    "  transform.translate {x, y, z}       by so many metres\n"
    "  transform.rotate { axis = {0, 1, 0}, angle = 30, about = {0, 0, 0} }\n"
    "                                  degrees, counter-clockwise as seen from the\n"
    "                                  tip of the axis; about may be left out\n"
    "  transform.scale(2)                  or {x, y, z}, one factor for each axis\n"
    "  transform.look_at { from = {..}, at = {..}, up = {0, 1, 0} }\n"
    "                                  the origin goes to from, -Z points to at; up\n"
    "                                  may be left out\n"
    "  transform.matrix { {1, 0.5, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0} }\n"
    "                                  three rows of four numbers, or 12 in a list:\n"
    "                                  this one shears, x grows by half of y\n"
    "\n"
    "  local grow, lift = transform.scale(2), transform.translate {0, 1, 0}\n"
    "  sphere { radius = 1, transform = lift * grow }\n"
    "\n"
    "a * b applies b first: the sphere grows, then it moves.";

static const char triangle_text[] =
    "  triangle { {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, material = red }\n"
    "\n"
    "Three corners in metres. It takes material, transform and name; many of them\n"
    "are better one mesh { positions = .., indices = .. }.";

static const char print_text[] = "  print(\"depth is\", depth)\n"
                                 "\n"
                                 "A line on standard error, with file and line, unless --quiet.";

static const char units_text[] =
    "  lengths       metres; a file whose format has no unit: 1 = 1 m\n"
    "  angles        degrees\n"
    "  intensity     of a point: watts per steradian, for each of red, green, blue\n"
    "  irradiance    of a direction: W/m^2 on what faces it\n"
    "  radiance      of surfaces, skies, emission: W/(m^2 sr)\n"
    "  power         of a whole light: watts\n"
    "  times         seconds; a shutter: frames\n"
    "  absorption    in glass: per metre, exp(-a d)\n"
    "  exposure      stops: twice as bright with each\n"
    "  colours       {r, g, b} or one number: linear, primaries of Rec. 709;\n"
    "                \"#rrggbb\" and 8-bit pictures: sRGB\n"
    "  axes          +Y is up; right-handed; a camera looks along its -Z";

static const char integrators_text[] =
    "  appel     Appel 1968: what the camera sees, lit by lights that nothing hides;\n"
    "            no reflections\n"
    "  whitted   Whitted 1980: mirrors and glass send on rays of their own, up to\n"
    "            --max-depth; matt surfaces see the lights. A rough metal shows only\n"
    "            the lights\n"
    "  cook      Cook 1984: every ray of that tree is drawn from a distribution: soft\n"
    "            shadows, gloss, depth of field, motion blur. What is rough finds small\n"
    "            lamps by chance only: path finds them better\n"
    "  path      Kajiya 1986: all light there is, by chance. Noise halves with four\n"
    "            times the samples; light through glass onto something else is the\n"
    "            noisiest\n"
    "\n"
    "            samples   max_depth\n"
    "  appel     4         0\n"
    "  whitted   16        10, or 24 with glass\n"
    "  cook      64        10, or 24 with glass\n"
    "  path      128       64\n"
    "\n"
    "A scene's samples and max_depth are meant for its own integrator: another one\n"
    "by -i takes these defaults. But for path, every ray that matters more than\n"
    "--min-weight is followed, and what was dropped is reported (--json,\n"
    "dropped_weight).";

static const char tonemaps_text[] =
    "  clip      what is brighter than 1 is cut off\n"
    "  reinhard  Reinhard 2002: c / (1 + c), on the luminance\n"
    "  neutral   Khronos PBR Neutral: colours up to 0.8 stay as they are, highlights\n"
    "            roll off; the default for models\n"
    "  aces      ACES 1.0 as Hill fits it: film-like, contrasty; 18 % grey gets darker\n"
    "            (10.6 %), so --exposure 0.7 or so helps\n"
    "  agx       AgX, base look: soft contrast; what is very bright turns white instead\n"
    "            of staying a pure colour\n"
    "\n"
    "Before it come --white-balance, then --exposure, in stops. A white balance is the\n"
    "light that is to look white: its temperature (candle 1850, lamp 2850, sun 5500,\n"
    "D65 6504, shade 8000 kelvin) or its colour. EXR and PFM have none of the three.";

static const char exit_text[] =
    "  0   done\n"
    "  1   the pictures differ; or some of several files failed\n"
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

static const char aovs_text[] =
    "  snell my.lua --aov depth,normal -o my.exr   all in one file\n"
    "  snell my.lua --aov depth,normal             my.png, my.depth.png, ..\n"
    "  render { aov = \"depth,normal\" }            the same in a scene\n"
    "\n"
    "AOVs are layers beside the picture, which stays as it is. Surface values are of\n"
    "the first surface that a camera ray meets: glass and mirrors too; what is there\n"
    "in part counts in part. An .exr and a .pfm hold the numbers, other files show\n"
    "them. Each with its channels in an .exr:\n";

const help_topic help_topics[] = {
    {"formats", NULL, "the files that are read and written", NULL, false},
    {"scene", NULL, "the scene language", scene_text, false},
    {"settings", "setting", "render{}, background{}, ambient{} and animation{}", settings_text,
     false},
    {"materials", "material", "how surfaces scatter light", materials_text, false},
    {"lights", "light", "where light comes from", lights_text, false},
    {"shapes", "shape", "what there is to see", shapes_text, false},
    {"cameras", "camera", "how rays start", cameras_text, false},
    {"textures", "texture", "what varies over a surface", textures_text, false},
    {"integrators", NULL, "how light is followed", integrators_text, false},
    {"tonemaps", NULL, "from radiance to a screen's colours", tonemaps_text, false},
    {"aovs", NULL, "layers beside the picture: depth, normals, mattes, light by kind", aovs_text,
     false},
    {"units", NULL, "what the numbers of a scene mean", units_text, false},
    {"exit", NULL, "what the exit code says", exit_text, false},
    {"environment", NULL, "variables that snell reads", environment_text, false},
    {"motion", NULL, "what moves, and the frames of an animation", motion_text, false},
    {"group", NULL, "several shapes as one", group_text, true},
    {"instance", NULL, "a shape, group or model at another place", instance_text, true},
    {"union", NULL, "closed shapes put together to one", solid_text, true},
    {"intersection", NULL, "what closed shapes have in common", solid_text, true},
    {"difference", NULL, "a closed shape less others", solid_text, true},
    {"model", NULL, "what another file draws", model_text, true},
    {"include", NULL, "all of another file", include_text, true},
    {"triangle", NULL, "a triangle by its corners", triangle_text, true},
    {"transform", NULL, "where a shape is", transform_text, true},
    {"param", NULL, "values from the command line", param_text, true},
    {"print", NULL, "a line for the person at the screen", print_text, true},
};
const size_t help_topic_count = sizeof help_topics / sizeof help_topics[0];

/* How the language writes types that it does not write as their table says. */
static const struct {
    const char *category, *name, *text;
} notes[] = {
    {"texture", "image",
     "In a scene: texture.image { file = \"wood.png\" }, PNG or JPEG. The file takes the place of "
     "width, height, format and pixels, which are for programs that use the library."},
    {"texture", "checker",
     "In a scene the two colours may come first: texture.checker { 0.9, 0.1, size = 0.5 }."},
    {"shape", "mesh",
     "In a scene also mesh { file = \"bunny.ply\" }: the surfaces of another file, with none of "
     "the fields below; and keys = { {time = 0, positions = {..}, normals = {..}}, .. } in place "
     "of "
     "positions, normals and key_times: 'snell help motion'."},
    {"shape", "heightfield",
     "In a scene 'heights' may also be a list of rows, {{0, 1}, {1, 2}}, which then says columns "
     "and rows, or a function of x and z; and file = \"hills.png\" may take the place of all "
     "three."},
    {"shape", "solid",
     "In a scene: union { a, b }, intersection { a, b } or difference { a, b }: 'snell help "
     "union'. "
     "The fields below are for programs that use the library."},
    {"setting", "animation",
     "In a scene 'frame' is not written: it comes from --frame. The call sets the globals time and "
     "frame, and stands before they are read: 'snell help motion'."},
    {"camera", "perspective",
     "In a scene: camera { from = {0, 2, 8} }, or camera { view = {30, 12}, of = shape }: 'snell "
     "help camera'."},
};

const char *help_note(const snell_type_info *type) {
    for (size_t i = 0; i < sizeof notes / sizeof notes[0]; i++) {
        bool same = strcmp(notes[i].name, type->name) == 0;
        if (same && strcmp(notes[i].category, type->category) == 0) return notes[i].text;
    }
    return NULL;
}

const char *help_common_fields(const char *category) {
    if (strcmp(category, "shape") == 0) return "material, transform, motion, name";
    if (strcmp(category, "camera") == 0) return "kind, name, view, of";
    return strcmp(category, "setting") == 0 ? NULL : "name";
}

const help_topic *help_find_topic(const char *word) {
    size_t length = strlen(word);
    for (int plural = 0; plural < 2; plural++) {
        for (size_t i = 0; i < help_topic_count; i++) {
            const char *name = help_topics[i].name;
            size_t span = strlen(name) - (plural && name[strlen(name) - 1] == 's');
            if (span == length && strncmp(name, word, length) == 0) return &help_topics[i];
            if (plural && length == span + 1 && strncmp(name, word, span) == 0 &&
                word[span] == 's') {
                return &help_topics[i];
            }
        }
    }
    return NULL;
}

/* What people call what has another name here: the pages, and all words that lead to them. A word that
 * is a page's own name needs no line. */
static const struct {
    const char *pages[2], *words;
} synonyms[] = {
    {{"formats"}, "jpg|jpeg|webp|apng|y4m|video|turntable"},
    {{"dielectric"}, "glass|water|ice|crystal|diamond|liquid|transparent|refraction"},
    {{"conductor"}, "metal|metallic|gold|silver|copper|chrome|aluminium|aluminum|steel|brass"},
    {{"lambert"}, "matte|diffuse|chalk|plaster"},
    {{"glazed", "principled"}, "plastic|ceramic|porcelain|varnish|lacquer|glaze"},
    {{"principled"}, "pbr|clearcoat|sheen|velvet|cloth|fabric"},
    {{"emissive"}, "glow|glowing|emitter|neon"},
    {{"directional", "sky"}, "sun|sunlight|daylight"},
    {{"quad", "disk"}, "softbox|area|area_light|window"},
    {{"point", "sphere"}, "lamp|bulb|lightbulb"},
    {{"environment"}, "hdri|hdr|ibl|skybox|envmap|dome"},
    {{"union", "difference"}, "csg|boolean|solids"},
    {{"curves"}, "hair|fur|grass|strand|strands|wool|curve|spline"},
    {{"heightfield"}, "terrain|landscape|hills|mountain|mountains"},
    {{"patch"}, "bezier|teapot|nurbs|patches"},
    {{"implicit"}, "formula|isosurface|equation"},
    {{"blob"}, "metaball|metaballs"},
    {{"julia"}, "fractal|quaternion"},
    {{"torus"}, "donut|doughnut"},
    {{"lathe"}, "vase|revolution|revolved"},
    {{"mesh"}, "polygon|polygons|triangles"},
    {{"plane"}, "floor|ground"},
    {{"perspective"}, "lens|pinhole|bokeh|dof|aperture|zoom"},
    {{"motion"}, "blur|motion_blur|keyframe|keyframes|keys"},
    {{"transform"}, "translate|rotate|scale|look_at|matrix|shear|move|turn"},
    {{"integrators"}, "appel|whitted|cook|path|kajiya|raytracing|pathtracing"},
    {{"aovs"}, "aov|layer|layers|depth|normals|albedo|cryptomatte|passes|pass|motion_vectors"},
    {{"formats"},
     "gltf|glb|obj|ply|stl|nff|pbrt|lua|png|exr|pfm|ppm|jpeg|webp|apng|y4m|file|files"},
    {{"tonemaps"}, "tonemap|clip|reinhard|neutral|aces|agx|white_balance"},
};

const char *help_find_synonym(const char *word, size_t at) {
    for (size_t i = 0; at < 2 && i < sizeof synonyms / sizeof synonyms[0]; i++)
        if (text_choice_has(synonyms[i].words, word)) return synonyms[i].pages[at];
    return NULL;
}
