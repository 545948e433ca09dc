# The page (viewer/) inside the program: built by npm into the build folder, then taken in as bytes.

# mien_page_library(NAME): a library that holds app/live/page_files.h's table. It is a library of its own so that nothing else
# waits until npm has built the page.
function(mien_page_library name)
  set(folder "${CMAKE_CURRENT_BINARY_DIR}/page")
  set(embedded "${CMAKE_CURRENT_BINARY_DIR}/page_files.cpp")
  if(MIEN_PAGE)
    find_program(MIEN_NPM npm)
    if(NOT MIEN_NPM)
      message(FATAL_ERROR "the page needs npm: install the packages nodejs and npm, or configure with -DMIEN_PAGE=OFF")
    endif()
    file(GLOB_RECURSE sources CONFIGURE_DEPENDS "${CMAKE_SOURCE_DIR}/viewer/src/*" "${CMAKE_SOURCE_DIR}/viewer/public/*")
    set(modules "${CMAKE_SOURCE_DIR}/viewer/node_modules/.package-lock.json")
    add_custom_command(
      OUTPUT "${modules}"
      COMMAND "${MIEN_NPM}" ci --no-audit --no-fund --loglevel=error
      WORKING_DIRECTORY "${CMAKE_SOURCE_DIR}/viewer"
      DEPENDS "${CMAKE_SOURCE_DIR}/viewer/package-lock.json"
      COMMENT "Fetching what the page is made of" VERBATIM)
    add_custom_command(
      OUTPUT "${folder}/index.html"
      COMMAND "${MIEN_NPM}" run --silent build -- --outDir "${folder}" --emptyOutDir
      WORKING_DIRECTORY "${CMAKE_SOURCE_DIR}/viewer"
      DEPENDS "${modules}" ${sources} "${CMAKE_SOURCE_DIR}/viewer/index.html" "${CMAKE_SOURCE_DIR}/viewer/package.json"
              "${CMAKE_SOURCE_DIR}/viewer/vite.config.mjs" "${CMAKE_SOURCE_DIR}/viewer/tsconfig.json"
      COMMENT "Building the page" VERBATIM)
    set(built "${folder}/index.html")
  else()
    # Another name for each: a build folder that had the page keeps it, and must not take it in.
    set(folder "${CMAKE_CURRENT_BINARY_DIR}/no_page")
    set(embedded "${CMAKE_CURRENT_BINARY_DIR}/no_page_files.cpp")
    set(built "")
  endif()
  add_custom_command(
    OUTPUT "${embedded}"
    COMMAND "${CMAKE_COMMAND}" -DFOLDER=${folder} -DOUT=${embedded} -P "${CMAKE_SOURCE_DIR}/cmake/embed_files.cmake"
    DEPENDS ${built} "${CMAKE_SOURCE_DIR}/cmake/embed_files.cmake"
    COMMENT "Taking the page in" VERBATIM)
  add_library(${name} STATIC "${embedded}")
  target_link_libraries(${name} PRIVATE mien_live mien_warnings)
endfunction()
