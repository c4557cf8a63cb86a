# colmap_ext_module(<name> DEPENDS <modules> LIBRARIES <third-party targets>)
# makes the static library colmap_ext_<name> from src/<name>/*.cc. Public headers are in
# include/colmap_ext/<name>/, private ones beside their .cc files.
add_library(colmap_ext_warnings INTERFACE)
target_compile_options(colmap_ext_warnings INTERFACE -Wall -Wextra -Wconversion -Werror)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  # GCC 12 sees overlapping copies in std::string's operator+ that are not there (GCC bug 105651).
  target_compile_options(colmap_ext_warnings INTERFACE -Wno-restrict)
endif()
if(CMAKE_UNITY_BUILD)
  # Each .cc is then a "header" of the generated file, whose anonymous types GCC suspects.
  target_compile_options(colmap_ext_warnings INTERFACE -Wno-subobject-linkage)
endif()
if(COLMAP_EXT_SANITIZE)
  target_compile_options(colmap_ext_warnings INTERFACE -fsanitize=${COLMAP_EXT_SANITIZE}
                                                       -fno-omit-frame-pointer)
  target_link_options(colmap_ext_warnings INTERFACE -fsanitize=${COLMAP_EXT_SANITIZE})
endif()

function(colmap_ext_module name)
  cmake_parse_arguments(ARG "" "" "DEPENDS;LIBRARIES" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cc)
  if(NOT sources)
    return()
  endif()
  add_library(colmap_ext_${name} STATIC ${sources})
  add_library(colmap_ext::${name} ALIAS colmap_ext_${name})
  target_include_directories(
    colmap_ext_${name}
    PUBLIC $<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}/include>
           $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>
    PRIVATE ${CMAKE_SOURCE_DIR}/src)
  list(TRANSFORM ARG_DEPENDS PREPEND colmap_ext_)
  target_link_libraries(colmap_ext_${name} PUBLIC ${ARG_DEPENDS} ${ARG_LIBRARIES}
                                           PRIVATE $<BUILD_INTERFACE:colmap_ext_warnings>)
  set_target_properties(colmap_ext_${name} PROPERTIES EXPORT_NAME ${name})
  install(TARGETS colmap_ext_${name} EXPORT colmap_ext-targets COMPONENT development
          ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
  set_property(GLOBAL APPEND PROPERTY COLMAP_EXT_MODULES colmap_ext_${name})
endfunction()

# colmap_ext_tests(<module> [LIBRARIES ...]) makes test_<module> from tests/<module>/*_test.cc.
function(colmap_ext_tests name)
  cmake_parse_arguments(ARG "" "" "LIBRARIES" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*_test.cc)
  if(NOT sources)
    return()
  endif()
  add_executable(test_${name} ${sources})
  target_include_directories(test_${name} PRIVATE ${CMAKE_SOURCE_DIR}/src ${CMAKE_SOURCE_DIR}/tests)
  target_link_libraries(test_${name} PRIVATE ${ARG_LIBRARIES} GTest::gtest_main
                                             colmap_ext_warnings)
  # Files of tests below the build folder: two builds may be tested at once.
  file(MAKE_DIRECTORY "${CMAKE_BINARY_DIR}/test_tmp")
  gtest_discover_tests(test_${name} DISCOVERY_MODE PRE_TEST
    PROPERTIES TIMEOUT 1500 ENVIRONMENT "TEST_TMPDIR=${CMAKE_BINARY_DIR}/test_tmp")
endfunction()

# colmap_ext_bench(<name> [LIBRARIES ...]) makes bench_<name> from bench/<name>/*.cc.
function(colmap_ext_bench name)
  cmake_parse_arguments(ARG "" "" "LIBRARIES" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cc)
  add_executable(bench_${name} ${sources})
  target_include_directories(bench_${name} PRIVATE ${CMAKE_SOURCE_DIR}/src)
  target_link_libraries(bench_${name} PRIVATE colmap_ext_bench_support ${ARG_LIBRARIES}
                                              colmap_ext_warnings)
endfunction()
