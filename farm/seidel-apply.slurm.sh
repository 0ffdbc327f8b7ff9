#!/usr/bin/env bash
# Blurs the frames of a shot with `seidel apply` as an array of Slurm jobs, a chunk of frames each.
#
#   farm/seidel-apply.slurm.sh FIRST-LAST CHUNK LENS PLATES OUTPUTS [OPTIONS OF seidel apply]
#
# PLATES and OUTPUTS are frame patterns, such as shot/plate.%04d.exr. SBATCH_PARTITION, SBATCH_TIMELIMIT and other
# variables of sbatch apply; SEIDEL_COMMAND is the command on the nodes, `seidel` if not set. Finished frames are kept, so
# that the same line goes on where an earlier one stopped. docs/guide/farm.md says more.
#SBATCH --job-name=seidel-apply
#SBATCH --output=seidel-apply.%A_%a.log
#SBATCH --open-mode=append
#SBATCH --requeue
set -euo pipefail

usage() {
    echo "$(basename "$0"): $1" >&2
    echo "usage: $(basename "$0") FIRST-LAST CHUNK LENS PLATES OUTPUTS [OPTIONS]" >&2
    exit 2
}

[ $# -ge 5 ] || usage "too few arguments"
[[ $1 =~ ^([0-9]+)(-([0-9]+))?$ ]] || usage "the frames \`$1\` are no range such as 1001-1100"
first=$((10#${BASH_REMATCH[1]})) last=$((10#${BASH_REMATCH[3]:-${BASH_REMATCH[1]}}))
[[ $2 =~ ^[1-9][0-9]*$ ]] || usage "the chunk \`$2\` is no number of frames"
chunk=$2
[ "$first" -le "$last" ] || usage "the frames \`$1\` end before they begin"

if [ -z "${SLURM_ARRAY_TASK_ID:-}" ]; then
    # Called by a user: submits itself, one task a chunk.
    exec sbatch --array="0-$(((last - first) / chunk))" "$0" "$@"
fi

from=$((first + SLURM_ARRAY_TASK_ID * chunk))
to=$((from + chunk - 1))
[ "$to" -le "$last" ] || to=$last
lens=$3 plates=$4 outputs=$5
shift 5
cpus=${SLURM_CPUS_PER_TASK:-1}
# As a step, so that the command gets the signal of scancel and removes its partial files.
exec srun --ntasks=1 --cpus-per-task="$cpus" "${SEIDEL_COMMAND:-seidel}" apply --lens "$lens" "$plates" -o "$outputs" \
    --frames "$from-$to" --skip-existing --threads "$cpus" "$@"
