# How every target of this project is built: flags, sanitizers, and the rooms of docs/design.md.

set(CMAKE_CXX_STANDARD 23)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)

# Paths are taken relative to the project's root, so that every preset and every clone shares one cache.
find_program(MIEN_CCACHE ccache)
if(MIEN_CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_BASEDIR=${CMAKE_SOURCE_DIR} CCACHE_NOHASHDIR=1
      CCACHE_SLOPPINESS=pch_defines,time_macros ${MIEN_CCACHE})
  if(CMAKE_CXX_COMPILER_ID MATCHES "Clang")
    add_compile_options("SHELL:-Xclang -fno-pch-timestamp")  # Else no precompiled header would be found again.
  endif()
endif()

# Determinism (docs/reference/determinism.md): no contraction of a*b+c that one compiler does and another does not.
add_compile_options(-ffp-contract=off)
if(MIEN_SANITIZE)
  add_compile_options(-fsanitize=${MIEN_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${MIEN_SANITIZE})
  if(MIEN_SANITIZE MATCHES "undefined")
    # A quarter of the compiling. The address sanitizer stops at a null dereference and at accesses beyond an object as
    # well; nothing then finds a wrong dynamic type (vptr), nor a null bound to a reference before it is used.
    add_compile_options(-fno-sanitize=null,object-size,vptr)
  endif()
endif()

# What users run reads what strangers send: addresses of functions are bound before main() and then read-only, and an
# overrun buffer ends the program. (Tests are not optimised, which FORTIFY wants; sanitizers see more themselves.)
add_link_options(-Wl,-z,relro,-z,now)
add_library(mien_hardening INTERFACE)
target_compile_options(mien_hardening INTERFACE "$<$<CONFIG:Release>:-fstack-protector-strong;-U_FORTIFY_SOURCE;-D_FORTIFY_SOURCE=2>")

# For what waits for people, files and networks: -O1 compiles it in two thirds of the time. What computes keeps -O3.
add_library(mien_cold INTERFACE)
target_compile_options(mien_cold INTERFACE "$<$<CONFIG:Release>:-O1>")

add_library(mien_warnings INTERFACE)
target_compile_options(mien_warnings INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Werror
                       -Wno-missing-field-initializers)  # Designated initialisers leave the rest to its defaults.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # g++ 12 sees overflows and uninitialised reads in Eigen's and the standard library's inlined code that are not there.
  target_compile_options(mien_warnings INTERFACE -Wno-maybe-uninitialized -Wno-array-bounds -Wno-stringop-overflow
                                                 -Wno-stringop-overread -Wno-restrict -Wno-dangling-pointer
                         -Wno-subobject-linkage)  # In a unit of several files each looks like a header to it.
endif()

# With MIEN_UNITY the sources are compiled that many at a time, which parses what they share once: names in anonymous
# namespaces are then unique in a target. The units name their files relative to the project's root (CMake's own unity
# builds: by absolute paths), so that every clone finds them in one cache. A file that cannot be among others is marked
# SKIP_UNITY_BUILD_INCLUSION before its target is made.
function(mien_units out name)
  set(apart)
  set(units)
  set(text "")
  set(count 0)
  foreach(source IN LISTS ARGN)
    get_source_file_property(skipped "${source}" SKIP_UNITY_BUILD_INCLUSION)
    if(skipped OR NOT MIEN_UNITY)
      list(APPEND apart "${source}")
      continue()
    endif()
    file(RELATIVE_PATH path "${CMAKE_SOURCE_DIR}" "${source}")
    string(APPEND text "#include \"${path}\"\n")
    math(EXPR count "${count} + 1")
    math(EXPR full "${count} % ${MIEN_UNITY}")
    if(full EQUAL 0)
      list(LENGTH units index)
      list(APPEND units "${CMAKE_CURRENT_BINARY_DIR}/units/${name}_${index}.cpp")
      file(CONFIGURE OUTPUT "units/${name}_${index}.cpp" CONTENT "${text}" @ONLY)
      set(text "")
    endif()
  endforeach()
  if(text)
    list(LENGTH units index)
    list(APPEND units "${CMAKE_CURRENT_BINARY_DIR}/units/${name}_${index}.cpp")
    file(CONFIGURE OUTPUT "units/${name}_${index}.cpp" CONTENT "${text}" @ONLY)
  endif()
  set(${out} ${units} ${apart} PARENT_SCOPE)
endfunction()

# What nearly every file includes, compiled once (with MIEN_UNITY; the plain builds of script/test --full show what a file
# forgot to include). The first target of a kind makes it, the others of that kind, which are compiled with the same
# options, take it over.
function(mien_precompiled target kind)
  if(NOT MIEN_UNITY)
    return()
  endif()
  get_property(owner GLOBAL PROPERTY MIEN_PRECOMPILED_${kind})
  if(owner)
    target_precompile_headers(${target} REUSE_FROM ${owner})
  else()
    target_precompile_headers(${target} PRIVATE ${ARGN})
    set_property(GLOBAL PROPERTY MIEN_PRECOMPILED_${kind} ${target})
  endif()
endfunction()
set(MIEN_PRECOMPILED_HEADERS <Eigen/Core> <Eigen/Dense> <Eigen/Geometry> <fmt/format.h> <algorithm> <array> <chrono> <cmath>
    <filesystem> <functional> <map> <memory> <mutex> <optional> <random> <ranges> <span> <string> <string_view> <thread>
    <variant> <vector>)

# mien_room(NAME [COLD] [FOLDERS folder...] [KNOWS room...] [USES library...] [HIDES library...]): one folder, one library
# target mien_NAME; COLD as mien_cold; FOLDERS are parts of the same target. KNOWS is the only way to reach another room:
# what it knows is reachable in turn, nothing else is. USES is what the room's headers need of libraries, HIDES what only
# its sources do. All rooms are in the global property MIEN_ROOMS, the folder of each in MIEN_FOLDER_OF_NAME: tests, checks
# and installation go by these.
function(mien_room name)
  cmake_parse_arguments(ROOM "COLD" "" "FOLDERS;KNOWS;USES;HIDES" ${ARGN})
  set(patterns "${CMAKE_CURRENT_SOURCE_DIR}/*.cpp")
  foreach(folder IN LISTS ROOM_FOLDERS)
    list(APPEND patterns "${CMAKE_CURRENT_SOURCE_DIR}/${folder}/*.cpp")
  endforeach()
  file(GLOB sources CONFIGURE_DEPENDS ${patterns})
  if(NOT sources)
    add_library(mien_${name} INTERFACE)
    set(scope INTERFACE)
  else()
    mien_units(units ${name} ${sources})
    add_library(mien_${name} STATIC ${units})
    set(scope PUBLIC)
    if(ROOM_COLD)
      target_link_libraries(mien_${name} PRIVATE $<BUILD_INTERFACE:mien_cold>)
      mien_precompiled(mien_${name} cold_room ${MIEN_PRECOMPILED_HEADERS})
    elseif(NOT name STREQUAL "train")  # libtorch's headers come with options of their own.
      mien_precompiled(mien_${name} room ${MIEN_PRECOMPILED_HEADERS})
    endif()
    target_link_libraries(mien_${name} PRIVATE $<BUILD_INTERFACE:mien_warnings> $<BUILD_INTERFACE:mien_hardening> ${ROOM_HIDES})
    # libFuzzer's counters: tests and fuzz targets share one build of the rooms.
    if(MIEN_FUZZ)
      target_compile_options(mien_${name} PRIVATE -fsanitize=fuzzer-no-link)
    endif()
  endif()
  target_include_directories(mien_${name} ${scope} $<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}> $<INSTALL_INTERFACE:include>)
  foreach(room IN LISTS ROOM_KNOWS)
    target_link_libraries(mien_${name} ${scope} mien_${room})
  endforeach()
  target_link_libraries(mien_${name} ${scope} ${ROOM_USES})
  add_library(mien::${name} ALIAS mien_${name})
  file(RELATIVE_PATH folder "${CMAKE_SOURCE_DIR}" "${CMAKE_CURRENT_SOURCE_DIR}")
  set_property(GLOBAL APPEND PROPERTY MIEN_ROOMS ${name})
  set_property(GLOBAL PROPERTY MIEN_FOLDER_OF_${name} "${folder}")
endfunction()

# Makes a text file (TOML, a page's script or style) part of a room, which then reads none at run time: `symbol`, a
# std::string_view of its text in the room's namespace, in `source` in the build folder. `path`: from the project's root.
function(mien_embed_text room path source symbol)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/${path}")
  file(READ "${PROJECT_SOURCE_DIR}/${path}" text)
  file(CONFIGURE OUTPUT "${source}" CONTENT [[
// Made of @path@.
#include <string_view>
namespace mien::@room@ {
extern const std::string_view @symbol@;
const std::string_view @symbol@ = R"text(@text@)text";
}  // namespace mien::@room@
]] @ONLY)
  target_sources(mien_${room} PRIVATE "${CMAKE_CURRENT_BINARY_DIR}/${source}")
endfunction()
