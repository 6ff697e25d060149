#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Starts LinuxCNC for sim/bus/linuxcnc/session.py. $1: a folder with the configuration, and with LinuxCNC's modules
# and ours in `modules`. LinuxCNC looks for modules in a folder of the system, refuses root, and uses shared memory,
# files in /tmp and the names of processes that two runs would share. Namespaces give it all of that alone, and
# leave the system as it is; they need no rights.
# With --try instead of a folder: exit status 0 if namespaces can be had.
set -eu
if [ "${2:-}" != inside ]; then
  exec unshare --user --map-root-user --mount --ipc --net --pid --fork --mount-proc --kill-child sh "$0" "$1" inside
fi
if [ "$1" = --try ]; then exec unshare --user --map-user=1000 --map-group=1000 true; fi
mount --bind "$1/modules" /usr/lib/linuxcnc/modules
mount --bind "$1" /mnt
mount -t tmpfs tmpfs /tmp
cd /mnt
exec unshare --user --map-user=1000 --map-group=1000 \
  env -i HOME=/mnt USER=microtick PATH=/usr/sbin:/usr/bin:/sbin:/bin LANG=C.UTF-8 /usr/bin/linuxcnc -r microtick.ini
