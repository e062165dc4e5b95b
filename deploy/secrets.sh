#!/bin/sh
# Draw the secrets of compose.yaml into ./secrets, each in a file; files that exist stay.
# Without Docker (docs/hosting.md) the stores have other names: DATABASE_HOST, BROKER_HOST.
# Readable inside the containers by any user, and outside by nobody else: the folder is closed.
set -eu
mkdir -p -m 0700 secrets
cd secrets
umask 022

# keep NAME: write standard input into a file, unless it exists.
keep() {
    [ -s "$1" ] || cat > "$1"
}

# hex BYTES: print random bytes.
hex() {
    od -An -N "$1" -tx1 /dev/urandom | tr -d ' \n'
}

for name in secret_key seed_key metrics_token postgres_password database_password \
    worker_database_password broker_password storage_secret_key; do
    hex 32 | keep "$name"
done
printf 'GK%s' "$(hex 12)" | keep storage_access_key # the form that Garage requires
database=${DATABASE_HOST:-postgres} broker=${BROKER_HOST:-redis}
printf 'postgresql://seamark:%s@%s/seamark' "$(cat database_password)" "$database" | keep database_url
printf 'postgresql://seamark_worker:%s@%s/seamark' "$(cat worker_database_password)" "$database" |
    keep worker_database_url
printf 'redis://:%s@%s:6379/0' "$(cat broker_password)" "$broker" | keep broker_url
keep objects.env <<TEXT
GARAGE_RPC_SECRET=$(hex 32)
GARAGE_DEFAULT_ACCESS_KEY=$(cat storage_access_key)
GARAGE_DEFAULT_SECRET_KEY=$(cat storage_secret_key)
TEXT
