#!/usr/bin/env bash
# ./scripts/bare_machine_test.sh [--suite NAME] [--ref COMMIT] [--deb FILE] [FOLDER]
# What a new user meets, on bare Debian (debootstrap's minbase in a chroot), with the seconds of each step:
#   sources   README's first command in a fresh clone, another scene, ensonify verify, and generate.sh again, which
#             must do nothing within 10 s; the Debian package; test.sh unless SKIP_TESTS is set
#   package   in a second chroot, without a compiler: apt-get install of the package, a data set, and the
#             time from the start to its first image, which must be within 60 s
# --suite NAME   Debian's bookworm (12, the default) or trixie (13)
# --ref COMMIT   test this commit of the repository (default: HEAD); what it does not have yet is left out
# --deb FILE     test this package alone, without the sources
# FOLDER         keeps the chroots, and takes up a bare system that is there (default: a temporary folder)
# DEBIAN_MIRROR  another mirror than deb.debian.org. Needs root, debootstrap and 6 GB.
set -euo pipefail

usage() {
  sed -n '2,13s/^# //p' "$0" >&2
  exit 2
}
root=$(cd "$(dirname "$0")/.." && pwd)
mirror=${DEBIAN_MIRROR:-http://deb.debian.org/debian}
suite=bookworm ref=HEAD deb='' folder='' keep=''
while [ $# -gt 0 ]; do
  case $1 in
    --suite | --ref | --deb)
      [ $# -ge 2 ] || usage
      case $1 in
        --suite) suite=$2 ;;
        --ref) ref=$2 ;;
        --deb) deb=$(realpath -e -- "$2") ;;
      esac
      shift
      ;;
    -*) usage ;;
    *) folder=$1 keep=yes ;;
  esac
  shift
done
folder=$(realpath -m -- "${folder:-$(mktemp -d /var/tmp/ensonify-bare-XXXXXX)}")
steps=()

clean_up() {
  local chroot
  for chroot in "$folder"/{sources,package}; do
    umount -l "$chroot/proc" "$chroot/sys" "$chroot/dev" 2>/dev/null || true
  done
  [ -n "$keep" ] || rm -rf --one-file-system "$folder"
}
trap clean_up EXIT

# bare NAME: a fresh chroot of this name.
bare() {
  local chroot=$folder/$1
  if [ ! -x "$folder/base/usr/bin/apt-get" ]; then
    debootstrap --variant=minbase "$suite" "$folder/base" "$mirror" >"$folder.log" 2>&1 ||
      { tail -5 "$folder.log" >&2; return 1; }
    rm -f "$folder.log"
  fi
  rm -rf --one-file-system "$chroot"
  cp -a "$folder/base" "$chroot"
  cp /etc/resolv.conf "$chroot/etc/resolv.conf"
  mount -t proc proc "$chroot/proc"
  mount --rbind --make-rslave /sys "$chroot/sys"
  mount --rbind --make-rslave /dev "$chroot/dev"
}

# inside NAME COMMAND: in that chroot, with no variable of this shell.
inside() {
  chroot "$folder/$1" /usr/bin/env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin \
    DEBIAN_FRONTEND=noninteractive bash -euc "cd /ensonify; $2"
}

# step NAME COMMAND: runs it there, and keeps a row of the table.
step() {
  local TIMEFORMAT='%R %U %S' status=0 wall user system
  echo "== $1: $2"
  { time inside "$1" "$2" >&3 2>&4 || status=$?; } 3>&1 4>&2 2>"$folder/seconds"
  read -r wall user system <"$folder/seconds"
  steps+=("$(printf '%-8s %9.1f %9.1f  %s' "$1" "$wall" "$(awk "BEGIN {print $user + $system}")" "$2")")
  last_wall=$wall
  [ $status -eq 0 ] || { table; echo "$1: $2: exit status $status" >&2; exit 1; }
}

table() {
  printf '\n%s, %s, %s processors\n%-8s %9s %9s  %s\n' "$(git -C "$root" describe --always "$ref")" "$suite" "$(nproc)" \
    where 'wall s' 'CPU s' step
  printf '%s\n' "${steps[@]}"
}

# within SECONDS LIMIT WHAT
within() {
  awk "BEGIN {exit !($1 <= $2)}" || { table; echo "$3: $1 s, more than $2 s" >&2; exit 1; }
}

from_sources() {
  bare sources
  git clone -q "$root" "$folder/sources/ensonify"
  git -C "$folder/sources/ensonify" checkout -q "$(git -C "$root" rev-parse "$ref^{commit}")"
  step sources './scripts/generate.sh'
  step sources './scripts/generate.sh scenes/two_cylinders.yaml out/two_cylinders'
  step sources 'build/release/ensonify verify out/sonar_tank'
  step sources './scripts/generate.sh'
  within "$last_wall" 10 'generate.sh again'
  if [ -x "$folder/sources/ensonify/scripts/package.sh" ]; then
    step sources './scripts/package.sh /package'
    deb=$(ls "$folder"/sources/package/ensonify_*.deb)
  fi
}

# first_image FOLDER FILE: writes the time at which the folder holds a PNG file.
first_image() {
  until [ -n "$(find "$1" -name '*.png' -print -quit 2>/dev/null)" ]; do sleep 0.1; done
  date +%s.%N >"$2"
}

from_package() {
  bare package
  mkdir "$folder/package/ensonify"
  cp "$deb" "$folder/package/ensonify/"
  rm -f "$folder/first_image"
  first_image "$folder/package/ensonify/out" "$folder/first_image" &
  local watcher=$! began seconds
  began=$(date +%s.%N)
  step package 'apt-get update -qq'
  step package 'apt-get install -y -qq ./ensonify_*.deb >/dev/null'
  step package 'ensonify generate /usr/share/ensonify/scenes/sonar_tank.yaml -o out'
  kill "$watcher" 2>/dev/null || true
  wait "$watcher" 2>/dev/null || true
  seconds=$(awk "BEGIN {printf \"%.1f\", $(cat "$folder/first_image") - $began}")
  steps+=("$(printf '%-8s %9.1f %9s  %s' package "$seconds" '' 'from the start to the first image')")
  step package 'ensonify verify out'
  step package '! command -v g++ cc'
  within "$seconds" 60 'the first image'
}

[ -n "$deb" ] && sources=no
[ "${sources:-}" = no ] || from_sources
if [ -n "$deb" ]; then from_package; else echo "$ref has no scripts/package.sh: no package is tested"; fi
[ "${sources:-}" = no ] || [ -n "${SKIP_TESTS:-}" ] || step sources './scripts/test.sh'
table
