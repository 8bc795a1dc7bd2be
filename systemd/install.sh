#!/bin/sh
# Installs the units beside an installed hil, or takes them away again: install.sh [--uninstall]
# PREFIX (/usr/local): hil is at PREFIX/bin/hil. DESTDIR: a tree to be packed, in which nothing is started.
set -eu
prefix=${PREFIX:-/usr/local}
root=${DESTDIR:-}
here=$(cd "$(dirname "$0")" && pwd)
lib=$root$prefix/lib
share=$root$prefix/share/hil/systemd

installed="$lib/systemd/system/hil.service $lib/systemd/system/hil@.service $lib/sysusers.d/hil.conf
$lib/tmpfiles.d/hil.conf $share/adapters.conf $share/can.conf $share/network.conf $share/realtime.conf
$share/usb.conf $share/usb-modules.conf $share/usb.rules"

tell_systemd() {
    if [ -z "$root" ] && [ -d /run/systemd/system ]; then
        systemctl daemon-reload
    fi
}

if [ "${1:-}" = --uninstall ]; then
    if [ -z "$root" ] && [ -d /run/systemd/system ]; then
        systemctl stop hil.service 'hil@*.service'
        for link in /etc/systemd/system/*.wants/hil.service /etc/systemd/system/*.wants/hil@*.service; do
            [ -L "$link" ] && systemctl disable --quiet "${link##*/}"
        done
    fi
    rm -f $installed
    rmdir "$share" "$root$prefix/share/hil" 2>/dev/null || :
    tell_systemd
    exit
fi

install -d "$lib/systemd/system" "$lib/sysusers.d" "$lib/tmpfiles.d" "$share"
for unit in hil.service hil@.service; do
    sed "s|/usr/local/|$prefix/|" "$here/$unit" >"$lib/systemd/system/$unit"
    chmod 644 "$lib/systemd/system/$unit"
done
install -m 644 "$here/sysusers.conf" "$lib/sysusers.d/hil.conf"
install -m 644 "$here/tmpfiles.conf" "$lib/tmpfiles.d/hil.conf"
for file in adapters.conf can.conf network.conf realtime.conf usb.conf usb-modules.conf usb.rules; do
    install -m 644 "$here/$file" "$share/$file"
done
if [ -z "$root" ] && [ -d /run/systemd/system ]; then
    systemd-sysusers hil.conf
    systemd-tmpfiles --create hil.conf
fi
tell_systemd
