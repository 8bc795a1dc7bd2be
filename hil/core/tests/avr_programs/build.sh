#!/bin/sh
# Assembles NAME.S to NAME.hex, with Debian's gcc-avr 5.4.0 and avr-libc 2.0.0 (its names of registers alone): build.sh FOLDER
cd "$(dirname "$0")" || exit 1
for source in *.S; do
    avr-gcc -mmcu=atmega328p -nostdlib -x assembler-with-cpp "$source" -o "$1/program.elf" &&
        avr-objcopy -O ihex "$1/program.elf" "$1/${source%.S}.hex" || exit 1
done
rm "$1/program.elf"
