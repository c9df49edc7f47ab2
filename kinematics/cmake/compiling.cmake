# How the code is compiled: the compiler cache, levels of optimisation and precompiled headers.

# ccache finds objects and precompiled headers again from any folder that holds a copy of this tree. A precompiled header
# is part of what it compares, so that must come out the same each time: GCC writes it by addresses, which setarch -R keeps.
find_program(CCACHE ccache)
if(CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_BASEDIR=${PROJECT_SOURCE_DIR} CCACHE_NOHASHDIR=1
      CCACHE_SLOPPINESS=pch_defines,time_macros CCACHE_DEPEND=1 CCACHE_INODECACHE=1)
  execute_process(COMMAND setarch -R true RESULT_VARIABLE status OUTPUT_QUIET ERROR_QUIET)
  if(status EQUAL 0)
    list(APPEND CMAKE_CXX_COMPILER_LAUNCHER setarch -R)
  endif()
  list(APPEND CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE})
endif()

# Hot code (kernels, evaluators, forward kinematics, blending, muscles) takes the level of the build type, -O3 for Release;
# what a person waits for once (files, commands, panels, reports, tests) takes -O1, which compiles faster. GCC compiles a
# file at the level that its precompiled header was made with, so each level has headers of its own.
# Only headers of the system are precompiled: a change in this tree makes none of them stale.
set(GELENK_STANDARD_HEADERS <algorithm> <array> <chrono> <cmath> <cstdint> <cstdio> <cstring> <filesystem> <fstream>
    <functional> <limits> <map> <memory> <numbers> <optional> <random> <set> <span> <sstream> <stdexcept> <string>
    <string_view> <utility> <vector> <Eigen/Core> <Eigen/Geometry>)

# gelenk_precompile(TARGET HEADERS...) or gelenk_precompile(TARGET REUSE_FROM LIKE)
function(gelenk_precompile target)
  if(ARGV1 STREQUAL "REUSE_FROM")
    target_precompile_headers(${target} ${ARGN})
  else()
    target_precompile_headers(${target} PRIVATE ${GELENK_STANDARD_HEADERS} ${ARGN})
  endif()
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # GCC 12 forgets which precompiled headers are the system's and reports them; clang's builds still look for these faults.
    target_compile_options(${target} PRIVATE -Wno-ignored-attributes -Wno-array-bounds -Wno-stringop-overflow)
  else()
    target_compile_options(${target} PRIVATE "SHELL:-Xclang -fno-pch-timestamp")
  endif()
endfunction()

# gelenk_cold(TARGET LIKE): compiled at -O1 in a Release build with the precompiled header of LIKE, a cold target;
# gelenk_cold(TARGET PRECOMPILE HEADERS...): with one of its own; gelenk_cold(TARGET): with none.
function(gelenk_cold target)
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
  if(ARGV1 STREQUAL "PRECOMPILE")
    list(REMOVE_AT ARGN 0)
    gelenk_precompile(${target} ${ARGN})
  elseif(ARGC GREATER 1)
    gelenk_precompile(${target} REUSE_FROM ${ARGV1})
  endif()
endfunction()

# gelenk_library(NAME HOT sources... COLD sources... LINK what target_link_libraries takes...): the library gelenk_NAME.
function(gelenk_library name)
  cmake_parse_arguments(PARSE_ARGV 1 part "" "" "HOT;COLD;LINK")
  set(target gelenk_${name})
  add_library(${target}_cold OBJECT ${part_COLD})
  add_library(${target} STATIC ${part_HOT} $<TARGET_OBJECTS:${target}_cold>)
  add_library(Gelenk::${name} ALIAS ${target})
  foreach(half ${target} ${target}_cold)
    target_include_directories(${half} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>)
    target_compile_features(${half} PUBLIC cxx_std_20)
    target_link_libraries(${half} ${part_LINK})
  endforeach()
  if(name STREQUAL kinematics)
    gelenk_precompile(${target})
    gelenk_cold(${target}_cold PRECOMPILE)
  else()
    gelenk_precompile(${target} REUSE_FROM gelenk_kinematics)
    gelenk_cold(${target}_cold gelenk_kinematics_cold)
  endif()
endfunction()
