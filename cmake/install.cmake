# What `cmake --install` puts where. Everything is relative to the prefix, which may be moved
# afterwards: the library finds the import helper from its own place, LIBDIR/../libexec/snell-import.
include(CMakePackageConfigHelpers)

install(TARGETS snell EXPORT snell-targets
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
  INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(FILES include/snell/snell.h
  DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/snell)
if(TARGET snell-cli)
  install(TARGETS snell-cli RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()
if(TARGET snell-import)
  install(TARGETS snell-import RUNTIME DESTINATION ${CMAKE_INSTALL_LIBEXECDIR})
endif()

# find_package(snell) gives snell::snell. In 0.x a minor version may change the library's face.
set(cmake_folder ${CMAKE_INSTALL_LIBDIR}/cmake/snell)
install(EXPORT snell-targets NAMESPACE snell:: DESTINATION ${cmake_folder} FILE snell-config.cmake)
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/snell-config-version.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/snell-config-version.cmake DESTINATION ${cmake_folder})

# pkg-config: the prefix is found from where the file lies.
file(RELATIVE_PATH SNELL_PREFIX_FROM_PC
  /prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig /prefix)
configure_file(cmake/snell.pc.in snell.pc @ONLY)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/snell.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)

# Manual pages and completion: the command writes them from its own table of options.
if(TARGET snell-cli AND NOT SNELL_SANITIZE AND NOT CMAKE_CROSSCOMPILING)
  set(texts ${CMAKE_CURRENT_BINARY_DIR}/texts)
  file(MAKE_DIRECTORY ${texts})
  # snell_text(FILE FOLDER ARGUMENT...): what `snell help ARGUMENT...` prints becomes share/FOLDER/FILE.
  function(snell_text file folder)
    add_custom_command(OUTPUT ${texts}/${file} DEPENDS snell-cli VERBATIM
      COMMAND snell-cli help ${ARGN} > ${texts}/${file})
    set_property(GLOBAL APPEND PROPERTY SNELL_TEXTS ${texts}/${file})
    install(FILES ${texts}/${file} DESTINATION ${CMAKE_INSTALL_DATADIR}/${folder})
  endfunction()
  snell_text(snell.1 man/man1 --man snell)
  foreach(command render explain info compare convert bench example help)
    snell_text(snell-${command}.1 man/man1 --man ${command})
  endforeach()
  snell_text(snell-scene.5 man/man5 --man scene)
  snell_text(snell bash-completion/completions --completion bash)
  snell_text(_snell zsh/site-functions --completion zsh)
  snell_text(snell.fish fish/vendor_completions.d --completion fish)
  get_property(written GLOBAL PROPERTY SNELL_TEXTS)
  add_custom_target(snell-texts ALL DEPENDS ${written})
endif()

if(EXISTS ${CMAKE_CURRENT_SOURCE_DIR}/scenes)
  install(DIRECTORY scenes/ DESTINATION ${CMAKE_INSTALL_DATADIR}/snell/scenes)
endif()
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
