# The loaders, one per node kind; included by firmware/boards/CMakeLists.txt. 4 KB of flash, and the RAM that an application has.
foreach(kind IN ITEMS tilt drive io gateway)
  hoist_image(
    hoist-boot-${kind} lpc11c24
    LINKER_SCRIPT ../boot/lpc11c24/loader.ld STACK_BYTES 1024 FLASH_MAX 4096 RAM_MAX 6144
    SOURCES ${HOIST_TOP}/firmware/boot/lpc11c24/main.cpp)
  target_compile_definitions(hoist-boot-${kind}-lpc11c24 PRIVATE HOIST_LOADER_KIND=${kind})
  # Smaller so: what is called once would otherwise be repeated within one function that has too many values for eight registers.
  target_compile_options(hoist-boot-${kind}-lpc11c24 PRIVATE -fno-inline-functions-called-once)
endforeach()
