#!/bin/bash
# An S3-compatible server for the tests: SeaweedFS (target/venv, put there by `sh setup.sh test`), on the loopback, with a
# bucket `team` and one pair of keys.
#   s3.sh up FOLDER [PID]   starts it and prints the lines that make a shell use it; ends it when process PID ends
#   s3.sh down FOLDER       ends it, and removes the folder
set -euo pipefail
[ $# -ge 2 ] || { sed -n '2,5s/^# //p' "$0" >&2; exit 2; }
weed="$(dirname "$(realpath "$0")")/../target/venv/bin/weed"
[ -x "$weed" ] || { echo "seaweedfs is missing: sh setup.sh test" >&2; exit 1; }
mkdir -p "$2"
at=$(realpath "$2")
key=test-key secret=test-secret

# Each of its servers also listens 10000 above.
free_ports() {
    python3 - <<'END'
import socket
found = []
while len(found) < 4:
    with socket.socket() as a, socket.socket() as b:
        a.bind(("127.0.0.1", 0))
        port = a.getsockname()[1] % 20000 + 20000
        try:
            with socket.socket() as c:
                c.bind(("127.0.0.1", port))
                b.bind(("127.0.0.1", port + 10000))
            found += [port] if port not in found else []
        except OSError:
            pass
print(*found)
END
}

up() {
    local master volume filer s3
    read -r master volume filer s3 < <(free_ports)
    mkdir -p "$at/data"
    cat >"$at/keys.json" <<END
{"identities": [{"name": "test", "credentials": [{"accessKey": "$key", "secretKey": "$secret"}],
  "actions": ["Admin", "Read", "Write", "List", "Tagging"]}]}
END
    setsid "$weed" server -dir="$at/data" -ip=127.0.0.1 -ip.bind=127.0.0.1 -master.telemetry=false -master.port="$master" \
        -volume.port="$volume" -filer -filer.port="$filer" -s3 -s3.port="$s3" -s3.config="$at/keys.json" \
        -s3.port.iceberg=0 -s3.port.lance=0 -master.volumeSizeLimitMB=64 -volume.max=8 >"$at/log" 2>&1 </dev/null &
    echo $! >"$at/pid"
    local made=
    for _ in $(seq 600); do
        made=$(curl -s -o /dev/null -w '%{http_code}' --aws-sigv4 aws:amz:us-east-1:s3 --user "$key:$secret" \
            -X PUT "http://127.0.0.1:$s3/team" || true)
        [ "$made" = 200 ] && break
        sleep 0.1
    done
    [ "$made" = 200 ] || { echo "SeaweedFS did not come up:" >&2; tail -n 20 "$at/log" >&2; exit 1; }
    if [ $# = 1 ]; then
        setsid bash -c "while kill -0 $1; do sleep 1; done; exec bash '$0' down '$at'" >/dev/null 2>&1 </dev/null &
    fi
    printf 'export AWS_ENDPOINT_URL=http://127.0.0.1:%s\nexport AWS_ACCESS_KEY_ID=%s\nexport AWS_SECRET_ACCESS_KEY=%s\n' "$s3" "$key" "$secret"
    echo 'export AWS_REGION=us-east-1'
}

down() {
    local pid
    pid=$(cat "$at/pid" 2>/dev/null) && kill -9 "$pid" 2>/dev/null || true
    rm -rf "$at"
}

case $1 in
up) up "${@:3}" ;;
down) down ;;
*) echo "$0: unknown: $1" >&2; exit 2 ;;
esac
