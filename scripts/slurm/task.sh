#!/usr/bin/env bash
# A task of the array that submit.sh submits: one shard of a sweep.
#   task.sh PROGRAM SWEEP OUT TASKS [OPTION-OF-SWEEP...]
# Told to end early (SIGTERM: two minutes before the time limit, or preempted), it passes that on:
# the program finishes the pings in hand, and the task puts itself into the queue again. So it does
# when the program was killed. It gives up when three starts in a row brought nothing.
#SBATCH --nodes=1
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=4
#SBATCH --requeue
#SBATCH --open-mode=append
#SBATCH --signal=B:TERM@120
set -uo pipefail

[ $# -ge 4 ] || { sed -n '2,3s/^# *//p' "$0" >&2; exit 2; }
program=$1 sweep=$2 out=$3 tasks=$4
shift 4
# The number of shards is that of when the array was submitted: by Slurm's variables, sbatch
# --array=3 for one lost task would be shard 0 of 1.
shard=$SLURM_ARRAY_TASK_ID/$tasks
job=${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID
threads=${SLURM_CPUS_PER_TASK:-${SLURM_CPUS_ON_NODE:-1}}
note=$out.slurm/$job.starts
told=0 child=''
trap 'told=$((told + 1)); [ -z "$child" ] || kill -TERM "$child" 2>/dev/null' TERM
say() { echo "task.sh: $(date -u +%FT%TZ) $job on ${SLURMD_NODENAME:-$(hostname)}: $1" >&2; }

# What this shard's runs have: files, bytes, and when a study's moments were last saved, whose size
# stays. Temporary files are no progress, nor is what other tasks do.
progress() {
  "$program" sweep "$sweep" --list --shard "$shard" | sed -nE 's/^([0-9a-f]{16}) .*/\1/p' |
    while read -r run; do
      cd "$out/runs/$run" 2>/dev/null &&
        find . -type f ! -path './.work/tmp/*' -printf '%f %s %T@\n'
    done | awk '
      { bytes += $2 }
      $1 == "moments.bin" && $3 > saved { saved = $3 }
      END { printf "%d files, %.0f bytes%s\n", NR, bytes, saved ? ", moments of " saved : "" }'
}

idle_starts=0
now=$(progress)
if [ -f "$note" ]; then
  read -r idle_starts before <"$note"
  if [ "$now" = "$before" ]; then idle_starts=$((idle_starts + 1)); else idle_starts=0; fi
fi
if [ "$idle_starts" -ge 3 ]; then
  say "three starts in a row brought nothing ($now): not started again.
Is there too little memory, or too little time for a ping? docs/cluster.md"
  rm -f "$note"
  exit 1
fi
echo "$idle_starts $now" >"$note"

say "shard $shard, $threads threads, start $((${SLURM_RESTART_COUNT:-0} + 1)), $now so far"
# In the background, for a shell that waits for a program in the foreground hears no signal. Not by
# srun, which would stand between the signal and the program.
"$program" sweep "$sweep" -o "$out" --shard "$shard" --threads "$threads" "$@" &
child=$!
[ $told = 0 ] || kill -TERM "$child" # told before there was a program
while :; do
  told_before=$told
  wait "$child"
  status=$?
  [ "$told" = "$told_before" ] && break # else only `wait` was interrupted
done

case $status in
  130 | 137 | 143) ;;  # interrupted; killed, as for want of memory
  *)
    rm -f "$note"
    say "ended with $status"
    exit "$status"
    ;;
esac
# scancel sends SIGTERM too; then this job is no longer RUNNING and must not come back.
state=$(squeue -h -j "$job" -o %T)
if [ "$state" != RUNNING ]; then
  say "ended with $status, ${state:-gone}: not queued again"
  exit "$status"
fi
say "ended with $status (told to end $told times): into the queue again"
scontrol requeue "$job"
