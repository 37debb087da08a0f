# Toolchain of the Cortex-M0 images: Debian's arm-none-eabi compiler (deploy/packages, group firmware).
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR armv6-m)
set(CMAKE_CXX_COMPILER arm-none-eabi-g++)
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_CXX_FLAGS_INIT "-mcpu=cortex-m0 -mthumb")
# Not Release: its -O3 makes images a third larger.
set(CMAKE_BUILD_TYPE MinSizeRel CACHE STRING "")
set(CMAKE_CXX_FLAGS_MINSIZEREL "-Os -g" CACHE STRING "")
