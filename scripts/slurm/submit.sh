#!/usr/bin/env bash
# ./scripts/slurm/submit.sh SWEEP OUT [--tasks N] [--gpus] [--program FILE] [-- SBATCH-OPTION...]
# Runs a sweep on a Slurm cluster: checks it, submits one array of N tasks (each takes a shard of
# many runs; default: 16, or as many as there are runs), and the step that gathers the results when
# all have ended. --gpus asks for one GPU a task and has the program use it. What is after -- goes
# to sbatch: -- --partition=long --time=8:00:00 --cpus-per-task=16 --mem=8G. The same command again
# submits what is missing. The program: --program, or build/release/ensonify, or the one on PATH.
set -euo pipefail

usage() {
  sed -n '2,8s/^# //p' "$0" >&2
  exit 2
}
fail() {
  echo "submit.sh: $1" >&2
  exit 2
}

here=$(cd "$(dirname "$0")" && pwd)
sweep='' out='' tasks='' program='' gpus=no
options=()
while [ $# -gt 0 ]; do
  case $1 in
    --tasks | --program)
      [ $# -ge 2 ] || fail "$1 needs a value"
      if [ "$1" = --tasks ]; then tasks=$2; else program=$2; fi
      shift
      ;;
    --gpus) gpus=yes ;;
    --) options=("${@:2}"); break ;;
    -*) usage ;;
    *) if [ -z "$sweep" ]; then sweep=$1; elif [ -z "$out" ]; then out=$1; else usage; fi ;;
  esac
  shift
done
[ -n "$out" ] || usage
[[ -z $tasks || $tasks =~ ^[1-9][0-9]{0,5}$ ]] ||
  fail "--tasks $tasks: expected a whole number from 1"
for option in "${options[@]}"; do
  case $option in
    --array* | -a*) fail "$option: the array is made by --tasks, a shard for each task" ;;
    --nodes* | -N* | --ntasks* | -n*) fail "$option: a task is one process on one node" ;;
  esac
done
command -v sbatch >/dev/null || {
  echo "submit.sh: no sbatch here; on one machine: ensonify sweep $sweep -o $out" >&2
  exit 4
}
if [ -z "$program" ]; then
  program=$here/../../build/release/ensonify
  [ -x "$program" ] || program=$(command -v ensonify) ||
    fail "no program; build it, or name it with --program"
fi
# Jobs start in other folders, on other machines.
program=$(realpath -- "$program")
sweep=$(realpath -m -- "$sweep")
out=$(realpath -m -- "$out")

# Every fault of every run is told here, not by the first task at night.
list=$("$program" sweep "$sweep" --list -o "$out") || exit
runs=$(grep -cE '^[0-9a-f]{16} ' <<<"$list") || fail "the sweep has no runs"
grep '^#' <<<"$list"

tasks=${tasks:-16}
[ "$tasks" -le "$runs" ] || tasks=$runs
most=$(scontrol show config | sed -n 's/^MaxArraySize *= *//p') || {
  echo "submit.sh: Slurm's controller does not answer; nothing was submitted" >&2
  exit 4
}
if [ "$tasks" -gt "$most" ]; then
  echo "submit.sh: this cluster's arrays have at most $most tasks (MaxArraySize): $most it is" >&2
  tasks=$most
fi

logs=$out.slurm
mkdir -p "$logs"
name=$(basename "${sweep%.*}")
wants=() with=()
if [ $gpus = yes ]; then
  wants=(--gres=gpu:1)
  with=(--backend cuda)
fi
# Ours come last, since sbatch takes the last of two.
array=$(sbatch --parsable --job-name="$name" --output="$logs/%A_%a.log" "${wants[@]}" \
  "${options[@]}" --array="0-$((tasks - 1))" \
  "$here/task.sh" "$program" "$sweep" "$out" "$tasks" "${with[@]}")
array=${array%%;*}  # ID;CLUSTER where there are several
# afterany: with afterok one failed run would hold it back for ever.
last=$(sbatch --parsable --job-name="$name-end" --output="$logs/%j_end.log" "${options[@]}" \
  --cpus-per-task=1 --dependency="afterany:$array" \
  "$here/finish.sh" "$program" "$sweep" "$out") || {
  scancel "$array"
  fail "the last step was refused; the array is cancelled again"
}
last=${last%%;*}

quoted() { printf '%q' "$1"; }
cat <<TEXT
submitted: array $array ($runs runs in $tasks tasks), then job $last, which gathers the results
watch:     squeue -j $array,$last
           $(quoted "$program") sweep $(quoted "$sweep") -o $(quoted "$out") --status
           tail -f $(quoted "$logs/${array}_0.log")
stop:      scancel $array $last
again:     this command; it takes up what is missing
TEXT
