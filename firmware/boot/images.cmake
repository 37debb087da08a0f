# What firmware/boards includes by this name.
include(${CMAKE_CURRENT_LIST_DIR}/CMakeLists.txt)
