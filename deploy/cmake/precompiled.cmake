# Headers that many sources of a target include, compiled once: the standard library's and those of Debian packages. Never a header of this tree: each
# source includes what it uses, and a changed header must not rebuild everything. Only for g++, and not for sanitizers: those builds also keep the
# warnings that g++ 12 gives falsely about std::string once <string> is precompiled.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND NOT HOIST_SANITIZE)
  set(HOIST_PRECOMPILE ON)
  add_compile_options(-fpch-preprocess)  # ccache asks for it
endif()
function(hoist_precompile target)
  if(HOIST_PRECOMPILE)
    target_precompile_headers(${target} PRIVATE ${ARGN})
    target_compile_options(${target} PRIVATE -Wno-array-bounds -Wno-restrict -Wno-stringop-overflow -Wno-stringop-overread)
  endif()
endfunction()
