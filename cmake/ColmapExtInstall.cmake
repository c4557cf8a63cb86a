# What `cmake --install` puts where, for users of the programs and for programs that link the modules
# (`find_package(colmap_ext)`, targets colmap_ext::<module>), and the Debian packages of CPack.
include(CMakePackageConfigHelpers)

set(config_folder ${CMAKE_INSTALL_LIBDIR}/cmake/colmap_ext)

install(FILES LICENSE README.md DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT runtime)
install(DIRECTORY docs/ DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT runtime)
install(DIRECTORY include/colmap_ext DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development)
install(EXPORT colmap_ext-targets NAMESPACE colmap_ext:: DESTINATION ${config_folder}
        COMPONENT development)

configure_package_config_file(
  ${CMAKE_CURRENT_LIST_DIR}/colmap_ext-config.cmake.in
  ${CMAKE_BINARY_DIR}/colmap_ext-config.cmake INSTALL_DESTINATION ${config_folder}
  NO_SET_AND_CHECK_MACRO NO_CHECK_REQUIRED_COMPONENTS_MACRO)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/colmap_ext-config-version.cmake
                                 COMPATIBILITY SameMinorVersion)
# The same list of packages that the build found.
install(FILES ${CMAKE_BINARY_DIR}/colmap_ext-config.cmake
              ${CMAKE_BINARY_DIR}/colmap_ext-config-version.cmake
              ${CMAKE_CURRENT_LIST_DIR}/ColmapExtDependencies.cmake
        DESTINATION ${config_folder} COMPONENT development)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME colmap-ext)
set(CPACK_PACKAGE_CONTACT "colmap_ext maintainers <maintainers@users.noreply.invalid>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL runtime development)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
# The shared libraries come from the programs themselves; `colmap` is run, not linked.
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME colmap-ext)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_DEPENDS colmap)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libcolmap-ext-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SHLIBDEPS OFF)
# What scripts/install_dependencies.sh installs to build, without what only the tests need.
file(READ ${CMAKE_SOURCE_DIR}/scripts/install_dependencies.sh build_packages)
string(REGEX REPLACE "--tests.*" "" build_packages "${build_packages}")
string(REGEX MATCHALL "[a-z0-9.+-]+-dev" build_packages "${build_packages}")
list(JOIN build_packages ", " CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS)
include(CPack)
