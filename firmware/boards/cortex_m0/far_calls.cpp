// From flash into RAM: a branch reaches 16 MB, RAM is 256 MB away. The linker's own veneers are twice as long, because they must keep all
// registers; a called function need not, and none of these has a fourth argument.
asm(R"(
  .syntax unified
  .macro far_call name, target
    .section .text.far.\name, "ax", %progbits
    .align 2
    .global \name
    .type \name, %function
    .thumb_func
  \name:
    ldr r3, 1f
    bx r3
    .align 2
  1:
    .word \target
    .size \name, . - \name
  .endm
  far_call __aeabi_fadd, hoist_fadd
  far_call __aeabi_fsub, hoist_fsub
  far_call __aeabi_frsub, hoist_frsub
  far_call __aeabi_fmul, hoist_fmul
  far_call __aeabi_fdiv, hoist_fdiv
  far_call __aeabi_fcmpun, hoist_fcmpun
  far_call __aeabi_fcmpeq, hoist_fcmpeq
  far_call __aeabi_fcmplt, hoist_fcmplt
  far_call __aeabi_fcmple, hoist_fcmple
  far_call __aeabi_fcmpgt, hoist_fcmpgt
  far_call __aeabi_fcmpge, hoist_fcmpge
  far_call __aeabi_ui2f, hoist_ui2f
  far_call __aeabi_i2f, hoist_i2f
  far_call __aeabi_f2iz, hoist_f2iz
  far_call __aeabi_f2uiz, hoist_f2uiz
  far_call memcpy, hoist_memcpy
  far_call memset, hoist_memset
  .text
)");
