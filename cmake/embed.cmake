# Writes OUTPUT, a C file with every FOLDER/*.lua in it as bytes, for `snell example`.
file(GLOB scenes ${FOLDER}/*.lua)
list(SORT scenes)
set(arrays "")
set(rows "")
set(index 0)
foreach(scene ${scenes})
  get_filename_component(name ${scene} NAME_WE)
  file(SIZE ${scene} size)
  file(READ ${scene} hex HEX)
  string(REGEX REPLACE "(..)" "0x\\1," bytes "${hex}")
  string(REGEX REPLACE "(................................................................................)"
    "\\1\n    " bytes "${bytes}")
  string(APPEND arrays "static const unsigned char scene_${index}[] = {\n    ${bytes}0x00};\n")
  string(APPEND rows "    {\"${name}\", scene_${index}, ${size}},\n")
  math(EXPR index "${index} + 1")
endforeach()
file(WRITE ${OUTPUT}.new "/* Generated from scenes/ by cmake/embed.cmake. */
#include \"examples.h\"\n
${arrays}
const example_scene example_table[] = {\n${rows}};
const size_t example_count = ${index};\n")
execute_process(COMMAND ${CMAKE_COMMAND} -E copy_if_different ${OUTPUT}.new ${OUTPUT})
file(REMOVE ${OUTPUT}.new)
