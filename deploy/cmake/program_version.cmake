# hoist_program_version: which source the programs are built from (control/contract/program_version.hpp). The history is read at each
# build; the one generated file changes only with the result, so that a commit compiles only this file and links.
find_package(Git QUIET)
set(program_version_source ${CMAKE_BINARY_DIR}/generated/program_version.cpp)
add_custom_target(program_version_source
  COMMAND ${CMAKE_COMMAND} -DTREE=${CMAKE_SOURCE_DIR} -DVERSION=${PROJECT_VERSION} -DGIT=${GIT_EXECUTABLE} -DOUT=${program_version_source}
          -P ${CMAKE_CURRENT_LIST_DIR}/write_program_version.cmake
  BYPRODUCTS ${program_version_source}
  COMMENT "" VERBATIM)
add_library(hoist_program_version STATIC ${program_version_source})
add_dependencies(hoist_program_version program_version_source)
