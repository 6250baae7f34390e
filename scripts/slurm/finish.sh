#!/usr/bin/env bash
# The step after the array that submit.sh submits: gathers the results, whatever became of it.
#   finish.sh PROGRAM SWEEP OUT
# Ends with 3 where runs failed or are missing; the table of those that are there is written too.
#SBATCH --nodes=1
#SBATCH --ntasks=1
#SBATCH --requeue
#SBATCH --open-mode=append
set -uo pipefail

program=$1 sweep=$2 out=$3
"$program" sweep "$sweep" -o "$out" --status
"$program" sweep "$sweep" -o "$out" --finalize && exit
status=$?
[ $status = 2 ] || [ $status = 4 ] || exit $status
echo "finish.sh: not all runs are there; here is what is. submit.sh again takes up the rest" >&2
"$program" sweep "$sweep" -o "$out" --finalize --partial || exit
exit 3
