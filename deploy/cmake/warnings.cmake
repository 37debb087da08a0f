add_compile_options(-Wall -Wextra -Wpedantic -Wconversion -Wshadow -Wdouble-promotion)
# Warnings are errors with the compiler we develop with. A newer one knows new warnings, right and wrong ones; it must not stop a
# person on a newer Debian from building, who still sees them.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  add_compile_options(-Werror)
elseif(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # Takes any function from a temporary to a reference for dangling, also those that return a reference to another argument.
  add_compile_options(-Wno-dangling-reference)
endif()
# Host and Cortex-M0 must agree bit for bit on the laws, so no fused multiply-add behind our back.
add_compile_options(-ffp-contract=off)
# Sanitizers look at the code as it is written: full frames.
if(HOIST_SANITIZE)
  # The checks are the same without optimisation, which is half of what instrumented code takes to compile: what computes for minutes gets a little,
  # what waits (server/, tests/, all that ThreadSanitizer looks at) none.
  set(optimize -O1)
  if(HOIST_SANITIZE MATCHES thread)
    set(optimize -O0)
  endif()
  add_compile_options(-fsanitize=${HOIST_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer ${optimize} -g1)
  add_link_options(-fsanitize=${HOIST_SANITIZE})
  add_compile_definitions(HOIST_SANITIZED=1)
  # Asio has fences, which g++'s ThreadSanitizer does not support: it warns at every use. clang's does (deploy/dev check).
  if(HOIST_SANITIZE MATCHES thread AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    add_compile_options(-Wno-tsan)
  endif()
endif()
