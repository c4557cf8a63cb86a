# Every third-party package, found once. Why each is here: docs/dependencies.md.
find_package(Threads REQUIRED)
find_package(Boost 1.74 REQUIRED COMPONENTS program_options)
find_package(Eigen3 3.4 REQUIRED)
find_package(OpenCV 4.6 REQUIRED COMPONENTS core imgproc imgcodecs calib3d)
find_package(TBB REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(SQLite3 REQUIRED)
find_package(OpenSSL 3.0 REQUIRED COMPONENTS Crypto)
find_package(ZLIB REQUIRED)
find_package(Ceres REQUIRED)
find_package(assimp REQUIRED)
find_package(CGAL REQUIRED)
find_package(Open3D REQUIRED)
find_package(exiv2 REQUIRED)
# Debian keeps GeographicLib's find module in a folder of its own.
list(APPEND CMAKE_MODULE_PATH /usr/share/cmake/geographiclib)
find_package(GeographicLib REQUIRED)

# Debian's FLANN has no CMake package; its headers need LZ4.
find_path(FLANN_INCLUDE_DIR flann/flann.hpp REQUIRED)
find_library(FLANN_LIBRARY flann_cpp REQUIRED)
find_library(LZ4_LIBRARY lz4 REQUIRED)

# Debian 12 has Embree 3, Debian 13 has Embree 4: the headers and a few names differ.
find_package(embree 4 QUIET)
if(embree_FOUND)
  set(COLMAP_EXT_EMBREE_MAJOR 4)
else()
  find_package(embree 3 REQUIRED)
  set(COLMAP_EXT_EMBREE_MAJOR 3)
endif()
