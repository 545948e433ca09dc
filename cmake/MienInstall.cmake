# What `cmake --install` lays down: the programs, their parts (models, prompts, rigs), the library with its headers, and the CMake
# package `mien`, so that another project says find_package(mien) and links mien::virtual or any lower room.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# The program looks for its parts upwards from its own real path: a build folder outside the project gets links.
foreach(part models prompts rigs)
  if(NOT EXISTS "${CMAKE_BINARY_DIR}/${part}" AND NOT CMAKE_BINARY_DIR STREQUAL CMAKE_SOURCE_DIR)
    file(CREATE_LINK "${CMAKE_SOURCE_DIR}/${part}" "${CMAKE_BINARY_DIR}/${part}" SYMBOLIC)
  endif()
  install(DIRECTORY "${CMAKE_SOURCE_DIR}/${part}" DESTINATION "${CMAKE_INSTALL_DATADIR}/mien")
endforeach()

foreach(program mien mien-lab mien-train mien-media)
  if(TARGET ${program})
    install(TARGETS ${program} RUNTIME DESTINATION "${CMAKE_INSTALL_BINDIR}")
  endif()
endforeach()

# The library without train, media and onnx: these are for the program and its helpers, and would bring libtorch, FFmpeg
# and libonnx with them.
get_property(rooms GLOBAL PROPERTY MIEN_ROOMS)
list(REMOVE_ITEM rooms lab train media onnx)
foreach(room IN LISTS rooms)
  set_target_properties(mien_${room} PROPERTIES EXPORT_NAME ${room})
  install(TARGETS mien_${room} EXPORT mien_rooms ARCHIVE DESTINATION "${CMAKE_INSTALL_LIBDIR}")
  if(IS_DIRECTORY "${CMAKE_SOURCE_DIR}/mien/${room}")  # A part of a room comes with its room.
    install(DIRECTORY "${CMAKE_SOURCE_DIR}/mien/${room}" DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/mien"
            FILES_MATCHING PATTERN "*.h"
            # Headers of a room's own sources, which no installed header includes.
            PATTERN gltf EXCLUDE PATTERN compiler EXCLUDE REGEX "/take/(database|layout|new_file|opening|row_writer)\\.h$" EXCLUDE
            REGEX "/(imu/pipeline|render/renderer)_state\\.h$" EXCLUDE
            REGEX "/render/(gltf_asset|tile_painter)\\.h$" EXCLUDE
            REGEX "/(virtual/fault_table|session/json_fields|synthetic/recipe_table|performer/tables)\\.h$" EXCLUDE)
  endif()
endforeach()

set(package "${CMAKE_INSTALL_LIBDIR}/cmake/mien")
install(EXPORT mien_rooms NAMESPACE mien:: FILE mienRooms.cmake DESTINATION "${package}")
configure_package_config_file("${CMAKE_SOURCE_DIR}/cmake/mienConfig.cmake.in" "${CMAKE_BINARY_DIR}/mienConfig.cmake"
                              INSTALL_DESTINATION "${package}")
write_basic_package_version_file("${CMAKE_BINARY_DIR}/mienConfigVersion.cmake" COMPATIBILITY SameMinorVersion)
install(FILES "${CMAKE_BINARY_DIR}/mienConfig.cmake" "${CMAKE_BINARY_DIR}/mienConfigVersion.cmake" DESTINATION "${package}")
