#!/usr/bin/env bash
# ./scripts/bare_machine_test.sh [FOLDER]
# What a new user meets: a bare Debian 12 (debootstrap's minbase in a chroot), nothing in it but a
# clone. Runs generate.sh, ensonify verify, generate.sh again (which must do nothing within 10 s),
# then test.sh. Needs root, debootstrap and 6 GB in FOLDER (default: a temporary one, removed
# afterwards).
set -euo pipefail

root=$(cd "$(dirname "$0")/.." && pwd)
bare=${1:-$(mktemp -d /var/tmp/ensonify-bare-XXXXXX)}
mirror=${DEBIAN_MIRROR:-http://deb.debian.org/debian}

umount_all() {
  umount -l "$bare/proc" "$bare/sys" "$bare/dev" 2>/dev/null || true
}
clean_up() {
  umount_all
  [ -n "${keep:-}" ] || rm -rf --one-file-system "$bare"
}
[ $# -gt 0 ] && keep=yes
trap clean_up EXIT

if [ ! -x "$bare/usr/bin/apt-get" ]; then
  debootstrap --variant=minbase bookworm "$bare" "$mirror" >"$bare.log" 2>&1 ||
    { tail -5 "$bare.log" >&2; exit 1; }
fi
cp /etc/resolv.conf "$bare/etc/resolv.conf"
mount -t proc proc "$bare/proc"
mount --rbind /sys "$bare/sys"
mount --rbind /dev "$bare/dev"
rm -rf "$bare/ensonify"
git clone -q "$root" "$bare/ensonify"
inside() { chroot "$bare" /usr/bin/env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin bash -euc "cd /ensonify; $1"; }

echo "== generate.sh"
inside './scripts/generate.sh'
inside 'build/release/ensonify verify out/sonar_tank'
echo "== generate.sh again"
before=$(date +%s)
inside './scripts/generate.sh'
after=$(date +%s)
echo "second call: $((after - before)) s"
[ $((after - before)) -le 10 ]
[ -n "${SKIP_TESTS:-}" ] && exit
echo "== test.sh"
inside './scripts/test.sh'
