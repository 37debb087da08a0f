# shellcheck shell=bash
# cross-compiles the Cortex-M0 images and checks their size
#
# Images land in build/firmware/ as hoist-NODE-CHIP.elf and .bin, and as .hoistfw for the update over the bus. The build stops when one
# is too large, may need more stack than it has, or links what a node must not have (heap, printf, exceptions, 64-bit division, doubles);
# Rewrites firmware/SIZES.gen.md, and firmware/MACHINE.gen.md with the cost of the images on the chip models (tests/machine).
# options: --no-setup   leave the machine as it is
common_options firmware "$@"
setup build firmware
say "building (build/firmware/)"
build_tree build -DCMAKE_BUILD_TYPE=RelWithDebInfo -- firmware_files || die "the images did not build: see above"
[ -n "$(find build/firmware -maxdepth 1 -name '*.size' -print -quit 2>/dev/null)" ] ||
  die "no image was made: is arm-none-eabi-g++ installed? (deploy/packages, group firmware)"
{
  cat <<TEXT
<!-- Made by \`deploy/dev firmware\`; do not edit. -->

# Sizes of the images

Bytes, as $(arm-none-eabi-g++ -dumpfullversion) of arm-none-eabi-g++ makes them. Flash without the loader in front of it; RAM with vectors,
mailbox and the reserved stack. The stack that an image needs is the sum of its deepest calls and of all interrupts, from its machine code
(\`firmware/cmake/stack_depth.awk\`); the build stops when less is reserved.

| image | flash | of | RAM | of | of it stack | needed |
|---|---|---|---|---|---|---|
TEXT
  sort build/firmware/*.size | while read -r name flash flash_most ram ram_most stack needed; do
    printf '| %s | %s | %s | %s | %s | %s | %s |\n' "$name" "$flash" "$flash_most" "$ram" "$ram_most" "$stack" "$needed"
  done
} >firmware/SIZES.gen.md
sed -n '/^|/p' firmware/SIZES.gen.md
say "running the LPC11C24 images on the model of their chip"
build_tree build -DCMAKE_BUILD_TYPE=RelWithDebInfo -- machine-report || die "the model did not build: see above"
build/bin/machine-report >build/firmware/machine.md || die "the images do not run: see above"
mv build/firmware/machine.md firmware/MACHINE.gen.md
sed -n '/^|/p' firmware/MACHINE.gen.md
