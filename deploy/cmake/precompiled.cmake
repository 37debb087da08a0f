# Two ways to compile less. clang-tidy looks at each source by itself (-DHOIST_JOIN=OFF), so each still includes what it uses.
#   Several sources of a target are compiled as one: each would instantiate the same templates of Debian's packages again, which is half the time,
#   and under the sanitizers more.
#   Headers that many sources of a target include are compiled once: the standard library's and those of Debian packages. Never a header of this
#   tree, because a changed header must not rebuild everything. g++ 12 then gives some warnings about std::string falsely.
option(HOIST_JOIN "several sources as one, and precompiled headers" ON)
# ccache asks for these.
if(HOIST_JOIN AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  add_compile_options(-fpch-preprocess)
elseif(HOIST_JOIN)
  add_compile_options("SHELL:-Xclang -fno-pch-timestamp")
endif()
# hoist_join(TARGET [ALONE FILES…]): FILES have private names that other sources of the target have, too. What replaces operator new is alone in
# every target.
function(hoist_join target)
  if(HOIST_JOIN)
    cmake_parse_arguments(arg "" "" "ALONE" ${ARGN})
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 12)
    set_source_files_properties(${arg_ALONE} ${CMAKE_SOURCE_DIR}/control/run/heap_watch.cpp PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  endif()
endfunction()
function(hoist_precompile target)
  if(HOIST_JOIN)
    target_precompile_headers(${target} PRIVATE ${ARGN})
    if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
      target_compile_options(${target} PRIVATE -Wno-array-bounds -Wno-restrict -Wno-stringop-overflow -Wno-stringop-overread)
    endif()
  endif()
endfunction()
