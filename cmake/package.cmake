# What cpack makes of an installation: one Debian package of the command, the library and its header. tools/package
# runs it, and makes the tarball for machines where nothing can be installed.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME snell)
set(CPACK_PACKAGE_VENDOR "the snell contributors")
set(CPACK_PACKAGE_CONTACT "the snell contributors")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "ray tracer: give it a model or a scene, get a picture")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_THREADS 0)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION "snell renders glTF, OBJ, PLY, STL and scenes written in Lua without a GPU or a display,
 to the same picture on every machine. The library, its header, and the files for pkg-config and CMake are
 in this package too.")
# The libraries it needs, by the files themselves; its own is not looked for in another package.
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${CMAKE_CURRENT_BINARY_DIR})
file(WRITE ${CMAKE_CURRENT_BINARY_DIR}/triggers "activate-noawait ldconfig\n")
set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA ${CMAKE_CURRENT_BINARY_DIR}/triggers)
include(CPack)
