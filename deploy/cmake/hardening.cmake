# What the programs of this computer bring against their own mistakes; tests/contract/test_programs reads it back from the ELF files.
# Position-independent, and every address the linker fills in is filled in before main() and read-only from then on.
add_compile_options(-fPIE)
add_link_options(-pie LINKER:-z,relro LINKER:-z,now LINKER:-z,noexecstack)
# A wrong index, an empty optional or front() of an empty container ends the program; measured in deploy/DECISIONS.md.
add_compile_definitions(_GLIBCXX_ASSERTIONS)
add_compile_options(-fstack-protector-strong)
# Sanitizers look at the code as it is written: no fortify.
if(NOT HOIST_SANITIZE)
  add_compile_options($<$<NOT:$<CONFIG:Debug>>:-U_FORTIFY_SOURCE> $<$<NOT:$<CONFIG:Debug>>:-D_FORTIFY_SOURCE=2>)
endif()
# Returns and indirect calls land only where they may, on processors that check it.
if(CMAKE_SYSTEM_PROCESSOR MATCHES "^(x86_64|AMD64)$")
  add_compile_options(-fcf-protection=full)
  # The linker marks a program only when all its parts are marked, and Debian 12's start files are not. They return to their callers, so
  # the shadow stack is requested; branch tracking follows where the start files begin with a landing mark.
  add_link_options(LINKER:-z,shstk)
elseif(CMAKE_SYSTEM_PROCESSOR STREQUAL "aarch64")
  add_compile_options(-mbranch-protection=standard)
endif()
