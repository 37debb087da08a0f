# A second build of the same sources (another clone, CI, another sanitizer set) should cost seconds.
find_program(HOIST_CCACHE ccache)
if(HOIST_CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_BASEDIR=${CMAKE_SOURCE_DIR} CCACHE_NOHASHDIR=1
    CCACHE_SLOPPINESS=pch_defines,time_macros ${HOIST_CCACHE})
endif()
