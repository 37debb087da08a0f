# shellcheck shell=bash
# installs what is missing, builds, and starts simulator + control + server; Ctrl-C stops all
#
# Simulator and control run in lock-step: a busy computer slows simulated time, which the screen shows, and stops no walk.
# The server prints the console's address (with a one-time token) when it is ready. A program that dies is started again.
# options: --port PORT       the console's port (default 8080)
#          --scenario NAME   what the simulator plays (build/bin/hoist-sim --list names them; default "figure-eight")
#          --patient NAME    who walks in the simulator (the same list; default a patient of an even walk)
#          --state DIR       sockets and the simulated bus (default: a folder of this user and port under $XDG_RUNTIME_DIR or /tmp)
#          --data DIR        parameters and the database (default build/run-data)
#          --real-time       by the wall clock, over a pseudo terminal that speaks SLCAN: late frames stop the hoist as on a real one
#          --no-setup        leave the machine as it is
port=8080
scenario=figure-eight
patient=
state=
data=build/run-data
real_time=
while [ $# -gt 0 ]; do
  case $1 in
    --port | --scenario | --patient | --state | --data)
      [ -n "${2:-}" ] || die "$1 needs a value"
      printf -v "${1#--}" '%s' "$2"
      shift
      ;;
    --real-time) real_time=yes ;;
    *) common_option run "$1" ;;
  esac
  shift
done
if [[ ! $port =~ ^[0-9]{1,5}$ ]] || [ "$port" -lt 1 ] || [ "$port" -gt 65535 ]; then die "--port is a number from 1 to 65535, not '$port'"; fi
[[ $scenario =~ ^[A-Za-z0-9_-]+$ ]] || die "--scenario is a name of letters, digits, - and _, not '$scenario'"
[[ $patient =~ ^[A-Za-z0-9_-]*$ ]] || die "--patient is a name of letters, digits, - and _, not '$patient'"

# `hoist` runs the studies that the console offers.
setup_and_build build -- hoist hoist-sim hoist-control hoist-server
build_web
for program in hoist hoist-sim hoist-control hoist-server; do
  [ -x "build/bin/$program" ] || not_here_yet run "build/bin/$program is not in this tree"
done

# Sockets, token, parameters and recordings are for this user only.
umask 077
: "${state:=${XDG_RUNTIME_DIR:-/tmp}/hoist-$UID-$port}"
mkdir -p "$state" "$data"
chmod 700 "$state"
exec 9>"$state/lock"
flock -n 9 || die "another 'deploy/dev run' uses $state (choose another --port or --state)"
if (exec 3<>"/dev/tcp/127.0.0.1/$port") 2>/dev/null; then die "port $port is taken by another program (choose another --port)"; fi
links=("$state/can" "$state/step.sock" "$state/sim.sock" "$state/core.sock" "$state/token")
rm -f "${links[@]}"

supervisors=()
stopping=
# The last one started is stopped first, so that the drives' own watchdog is not what ends a walk.
stop_all() {
  [ -z "$stopping" ] || return 0
  stopping=yes
  trap '' INT TERM HUP
  local index
  for ((index = ${#supervisors[@]} - 1; index >= 0; index--)); do
    kill -TERM "${supervisors[index]}" 2>/dev/null || continue
    wait "${supervisors[index]}" 2>/dev/null || continue
  done
  rm -f "${links[@]}"
}
trap 'say "stopping"; stop_all; exit 0' INT TERM HUP
trap stop_all EXIT

# start NAME COMMAND...: the supervisor dies with us even when we are killed outright, and takes its program along.
start() {
  setpriv --pdeathsig TERM bash deploy/lib/supervise.sh "$@" 9>&- </dev/null &
  supervisors+=($!)
}

# await_path PATH: until a program has created its socket or link; no error if late, since its user reports that.
await_path() {
  local tries
  for ((tries = 0; tries < 100; tries++)); do
    if [ -e "$1" ] || [ -L "$1" ]; then return 0; fi
    sleep 0.05
  done
  say "$1 is still not there after 5 s; going on"
}

say "scenario '$scenario', state in $state, data in $data"
if [ -n "$real_time" ]; then
  line=$state/can
  sim_line=(--pty-link "$line")
  # An ordinary computer holds a program up for 10 to 100 ms now and then. A real hoist must stop for that (30 ms); here it would only stop
  # a simulated patient for no reason, so the bound is wider for this run and is not stored.
  control_line=(--bus "slcan:$line" --set loop_late_s_max=0.2)
else
  line=$state/step.sock
  sim_line=(--lock-step "$line")
  control_line=(--bus "sim:$line")
fi
start hoist-sim build/bin/hoist-sim --scenario "$scenario" ${patient:+--patient "$patient"} "${sim_line[@]}" --control "$state/sim.sock"
await_path "$line"
start hoist-control build/bin/hoist-control "${control_line[@]}" --socket "$state/core.sock" --params "$data/parameters.json"
await_path "$state/core.sock"
mkdir -p "$data/backups"
start hoist-server build/bin/hoist-server --socket "$state/core.sock" --port "$port" --web web/dist --db "$data/hoist.db" \
  --scenario "$scenario" --simulator "$state/sim.sock" --token-file "$state/token" --backup-root "$data/backups"

# A supervisor ends only when it has given up.
status=0
wait -n "${supervisors[@]}" || status=$?
say "a program cannot be kept running: stopping the others"
stop_all
exit "$((status == 0 ? 1 : status))"
