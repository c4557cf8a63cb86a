#!/usr/bin/env bash
# --jobs slurm under a real Slurm: job arrays and srun give the files of one process.
#   tests/system/slurm.sh [program]
# `program` is colmap_ext, default build/release/bin/colmap_ext. Starts a Slurm of one node with its
# own munge, ports and state below /var/tmp, and ends it, however the script ends. Needs Debian's
# slurm-wlm and munge; as root it installs them. A few minutes on two cores.
set -euo pipefail

program="$(realpath "${1:-$(dirname "$0")/../../build/release/bin/colmap_ext}")"
[[ -x "$program" ]] || { echo "$program: build colmap_ext first (scripts/build.sh)" >&2; exit 2; }
work="$(mktemp -d /var/tmp/colmap_ext_slurm.XXXXXX)"
export SLURM_CONF="$work/slurm.conf"
daemons=()

. "$(dirname "$0")/steps.sh"

end_slurm() {
  scancel --state=PENDING,RUNNING --user="$(id -un)" > /dev/null 2>&1 || true
  ((${#daemons[@]} == 0)) || kill "${daemons[@]}" 2> /dev/null || true
  wait
  rm -rf "$work"
}
trap end_slurm EXIT

require_slurm() {
  local missing=() name
  for name in slurmctld slurmd munged srun sbatch; do
    PATH="$PATH:/usr/sbin" command -v "$name" > /dev/null || missing+=("$name")
  done
  ((${#missing[@]})) || return 0
  [[ "$(id -u)" == 0 ]] || { echo "missing: ${missing[*]}; install slurm-wlm and munge" >&2; exit 2; }
  step "installing slurm-wlm and munge"
  quietly apt-get update -q
  quietly env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends slurm-wlm munge
}

# Four processors, whatever the machine has: four tasks have to run at once.
write_configuration() {
  chmod 755 "$work"
  mkdir "$work/state" "$work/spool" "$work/munge"
  chmod 700 "$work/munge"
  head -c 1024 /dev/urandom > "$work/munge/key"
  chmod 600 "$work/munge/key"
  cat > "$SLURM_CONF" << CONFIGURATION
ClusterName=colmap_ext_test
SlurmctldHost=$(hostname -s)(127.0.0.1)
SlurmctldPort=26817
SlurmdPort=26818
SlurmUser=$(id -un)
SlurmdUser=$(id -un)
AuthType=auth/munge
AuthInfo=socket=$work/munge/socket
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SlurmdParameters=config_overrides
ReturnToService=2
NodeName=$(hostname -s) NodeAddr=127.0.0.1 CPUs=4 State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE
CONFIGURATION
}

start_slurm() {
  step "Slurm of one node, $(srun --version)"
  PATH="$PATH:/usr/sbin"
  munged --foreground --force --socket="$work/munge/socket" --key-file="$work/munge/key" \
    --pid-file="$work/munge/pid" --seed-file="$work/munge/seed" --log-file="$work/munge/log" \
    > "$work/munged.log" 2>&1 &
  daemons+=($!)
  sleep 1
  slurmctld -D > "$work/slurmctld.log" 2>&1 &
  daemons+=($!)
  slurmd -D > "$work/slurmd.log" 2>&1 &
  daemons+=($!)
  local i
  for i in $(seq 60); do
    [[ "$(sinfo -h -o %T 2> /dev/null)" == idle ]] && return 0
    sleep 1
  done
  tail -n 5 "$work"/munged.log "$work"/slurmctld.log "$work"/slurmd.log >&2
  fail "Slurm's node did not become idle"
}

make_site() {
  step "24 photos of the boxes and their sparse model"
  quietly "$program" active_capture --workspace_path "$work/site" --scene boxes \
    --Session.vehicle embedded --Session.max_iterations 1 --InitialFlight.num_views 24 \
    --Session.pictures 0
}

input=()
arguments() {  # command, output
  input=("$program" "$1" --input_path "$work/site/iterations/000/sparse" --image_path "$work/site/images"
         --output_path "$work/$2")
  [[ "$1" != dense_reconstructor ]] || input+=(--backend builtin --DenseStereo.max_width_px 320)
}

checksums() { (cd "$work/$1" && find . -type f -exec sha256sum {} + | sort -k 2); }

expect_same() {  # output, what made it
  checksums one > "$work/one.txt"
  checksums "$1" | cmp - "$work/one.txt" || fail "$2: other files than by one process"
  echo "   $2: $(wc -l < "$work/one.txt") files as by one process"
}

submit() {  # range; waits for its end
  sbatch --wait --array="$1" --cpus-per-task=1 --output="$work/task_%a.log" "$work/job.sh" > /dev/null ||
    { tail -n 5 "$work"/task_*.log >&2; fail "a task of --array=$1"; }
}

by_array() {  # command, range
  arguments "$1" array
  printf '#!/bin/bash\nexport OMP_WAIT_POLICY=passive\nexec' > "$work/job.sh"
  printf ' %q' "${input[@]}" --jobs slurm --jobs_wait_s 600 >> "$work/job.sh"
  submit "$2"
  expect_same array "$1, sbatch --array=$2"
  rm -rf "$work/array"
}

by_srun() {  # command
  arguments "$1" srun
  quietly srun -n 4 -c 1 "${input[@]}" --jobs mpi --jobs_wait_s 600
  expect_same srun "$1, srun -n 4"
  rm -rf "$work/srun"
}

# A task that is cancelled half way: the array submitted again goes on with what is there.
by_cancelled_array() {
  arguments dense_reconstructor cancelled
  printf '#!/bin/bash\nexec' > "$work/job.sh"
  printf ' %q' "${input[@]}" --jobs slurm --jobs_wait_s 600 >> "$work/job.sh"
  local id
  id="$(sbatch --parsable --array=0-3 --cpus-per-task=1 --output="$work/task_%a.log" "$work/job.sh")"
  until (($(find "$work/cancelled" -type f 2> /dev/null | wc -l) > 8)); do sleep 0.2; done
  scancel --signal=KILL --full "$id"
  scancel "$id"
  while [[ -n "$(squeue -h)" ]]; do sleep 0.5; done
  echo "   cancelled with $(find "$work/cancelled" -type f | wc -l) files there"
  submit 0-2
  expect_same cancelled "dense_reconstructor, cancelled and submitted again as --array=0-2"
}

require_slurm
write_configuration
start_slurm
make_site
for command in superpixel_stereo dense_reconstructor; do
  step "$command"
  arguments "$command" one
  quietly "${input[@]}"
  by_array "$command" 0-3
  by_array "$command" 1-7:2
  by_srun "$command"
  [[ "$command" != dense_reconstructor ]] || by_cancelled_array
  rm -rf "$work/one"
done
step "all passed"
