# Checks one finished image: flash, RAM and the deepest stack against their limits, and forbidden symbols. Stops the build on any violation.
# IMAGE NAME NM SIZE OBJDUMP AWK STACK_BYTES FLASH_MAX RAM_MAX OUT
execute_process(COMMAND ${SIZE} -A ${IMAGE} OUTPUT_VARIABLE sections COMMAND_ERROR_IS_FATAL ANY)
set(flash 0)
set(ram ${STACK_BYTES})
foreach(section IN ITEMS .text .ARM.exidx .init_array .data)
  string(REGEX MATCH "\n\\${section} +([0-9]+) " found "${sections}")
  if(found)
    math(EXPR flash "${flash} + ${CMAKE_MATCH_1}")
  endif()
endforeach()
foreach(section IN ITEMS .data .bss)
  string(REGEX MATCH "\n\\${section} +([0-9]+) " found "${sections}")
  if(found)
    math(EXPR ram "${ram} + ${CMAKE_MATCH_1}")
  endif()
endforeach()
# 192 bytes of vectors, and up to 32 behind the stack: flash routines (LPC11C24) or mailbox (STM32F072).
math(EXPR ram "${ram} + 224")

execute_process(COMMAND ${NM} ${IMAGE} OUTPUT_VARIABLE symbols COMMAND_ERROR_IS_FATAL ANY)
set(problems "")
if(flash GREATER FLASH_MAX)
  list(APPEND problems "${flash} bytes of flash, at most ${FLASH_MAX}")
endif()
if(ram GREATER RAM_MAX)
  list(APPEND problems "${ram} bytes of RAM with ${STACK_BYTES} of stack, at most ${RAM_MAX}")
endif()
# Heap, text output, exceptions, guards of local statics, 64-bit division, double arithmetic, library mathematics.
set(forbidden
    "malloc|free|calloc|realloc|_sbrk|_Znwj|_Znaj|_ZdlPv|_ZdlPvj|_ZdaPv"
    "[a-z_]*printf[a-z_]*|[a-z_]*scanf[a-z_]*|puts|putchar|abort|exit|__assert_func"
    "__cxa_[a-z]*throw|__cxa_begin_catch|_Unwind_[A-Za-z]*|__gxx_personality_v0|__cxa_guard_[a-z]*|__cxa_atexit|__aeabi_unwind_cpp_pr[01]"
    "__aeabi_u?ldivmod|__divdi3|__udivdi3|__moddi3|__umoddi3"
    "__aeabi_d(add|sub|mul|div|cmp[a-z]*|rsub|2[a-z]+)|__(add|sub|mul|div)df3"
    "atan2?f?|sinf?|cosf?|tanf?|expf?|powf?|logf?|fmodf?")
foreach(pattern IN LISTS forbidden)
  string(REGEX MATCHALL " [TtWwDdBb] (${pattern})\n" found "${symbols}")
  foreach(symbol IN LISTS found)
    string(REGEX REPLACE " [A-Za-z] (.*)\n" "\\1" symbol "${symbol}")
    list(APPEND problems "links ${symbol}")
  endforeach()
endforeach()
# The deepest stack, by the frames and calls of the machine code.
set(code ${OUT}.code)
execute_process(COMMAND ${OBJDUMP} -s -j .text ${IMAGE} OUTPUT_FILE ${code} COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${OBJDUMP} -d --no-show-raw-insn ${IMAGE} OUTPUT_VARIABLE instructions COMMAND_ERROR_IS_FATAL ANY)
file(APPEND ${code} "${instructions}")
execute_process(
  COMMAND ${AWK} -f ${CMAKE_CURRENT_LIST_DIR}/stack_depth.awk ${code} OUTPUT_VARIABLE depth OUTPUT_STRIP_TRAILING_WHITESPACE
  RESULT_VARIABLE unbounded)
file(REMOVE ${code})
set(stack_need 0)
if(unbounded)
  list(APPEND problems "the stack has no bound: ${depth}")
else()
  string(REGEX MATCH "^[0-9]+" stack_need "${depth}")
  if(stack_need GREATER STACK_BYTES)
    list(APPEND problems "${STACK_BYTES} bytes of stack, and this path takes ${depth}")
  endif()
endif()
file(WRITE ${OUT} "${NAME} ${flash} ${FLASH_MAX} ${ram} ${RAM_MAX} ${STACK_BYTES} ${stack_need}\n")
message(STATUS "${NAME}: flash ${flash} of ${FLASH_MAX}, RAM ${ram} of ${RAM_MAX} (stack ${stack_need} of ${STACK_BYTES})")
if(problems)
  # A finished file would count as good.
  file(REMOVE ${IMAGE})
  list(JOIN problems "; " problems)
  message(FATAL_ERROR "${NAME}: ${problems}")
endif()
