# Looks through the committed files for what must not be there, the address of a package registry (a clone takes
# packages from the registry that its own machine is set to), and for what must: a corpus for every fuzz target, of
# files under 8 KB.
#   cmake -DROOT=<project> -P committed_files.cmake
cmake_minimum_required(VERSION 3.25)

find_package(Git QUIET)
if(Git_FOUND AND EXISTS "${ROOT}/.git")
  execute_process(COMMAND ${GIT_EXECUTABLE} -C "${ROOT}" -c safe.directory=* ls-files
                  OUTPUT_VARIABLE files OUTPUT_STRIP_TRAILING_WHITESPACE RESULT_VARIABLE status)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "git cannot list the files of ${ROOT}")
  endif()
  string(REPLACE "\n" ";" files "${files}")
else()
  # Not a clone (an unpacked archive): what is there, but for what builds leave behind.
  file(GLOB_RECURSE files RELATIVE "${ROOT}" "${ROOT}/*")
  list(FILTER files EXCLUDE REGEX "^(build|out)/|(^|/)node_modules/")
endif()

set(complaints "")
set(count 0)
foreach(file IN LISTS files)
  if(NOT EXISTS "${ROOT}/${file}" OR IS_DIRECTORY "${ROOT}/${file}"
     OR file MATCHES "\\.(png|jpg|glb|mp4|safetensors|mien|bin)$" OR file MATCHES "^fuzz/corpus/")
    continue()
  endif()
  math(EXPR count "${count} + 1")
  file(STRINGS "${ROOT}/${file}" lines
       REGEX "https?://[^ \"]*(registry|artifactory|nexus|/npm/|/pypi/)|\"resolved\"[ ]*:")
  foreach(line IN LISTS lines)
    string(APPEND complaints "${file}: ${line}\n")
  endforeach()
endforeach()

if(complaints)
  message(FATAL_ERROR "Addresses of package registries in committed files:\n${complaints}")
endif()

foreach(file IN LISTS files)
  if(file MATCHES "^fuzz/([a-z0-9_]+)_fuzz\\.cpp$")
    set(corpus ${files})
    list(FILTER corpus INCLUDE REGEX "^fuzz/corpus/${CMAKE_MATCH_1}/")
    if(NOT corpus)
      string(APPEND complaints "${file}: there is no file in fuzz/corpus/${CMAKE_MATCH_1}\n")
    endif()
  elseif(file MATCHES "^fuzz/corpus/" AND EXISTS "${ROOT}/${file}")
    file(SIZE "${ROOT}/${file}" bytes)
    if(bytes GREATER_EQUAL 8192)
      string(APPEND complaints "${file}: ${bytes} bytes; a corpus has files under 8 KB\n")
    endif()
  endif()
endforeach()
if(complaints)
  message(FATAL_ERROR "The fuzzer's corpora:\n${complaints}")
endif()
if(count EQUAL 0)
  message(FATAL_ERROR "No files were found under ${ROOT}: is this the project's root?")
endif()
message(STATUS "${count} files without a registry's address")
