#!/bin/sh
# The roles of the service in a new cluster: neither is a superuser. The image of PostgreSQL runs this
# once, before anyone can connect; for a cluster that exists, run it by hand as its superuser:
#   POSTGRES_USER=postgres POSTGRES_DB=seamark SECRETS=./secrets sh deploy/postgres/roles.sh
# or as root, who may read the secrets, with PSQL="runuser -u postgres -- psql".
set -e
secrets=${SECRETS:-/run/secrets}

{
    # Not as arguments, which every process of the host could read.
    printf '\\set owner_password %s\n' "$(cat "$secrets/database_password")"
    printf '\\set worker_password %s\n' "$(cat "$secrets/worker_database_password")"
    cat <<'SQL'
CREATE ROLE seamark LOGIN PASSWORD :'owner_password';
-- `seamark db grant-worker` gives this one its rights, when the tables are there.
CREATE ROLE seamark_worker LOGIN PASSWORD :'worker_password';
ALTER DATABASE :"database" OWNER TO seamark;
REVOKE ALL ON DATABASE :"database" FROM PUBLIC;
GRANT CONNECT ON DATABASE :"database" TO seamark_worker;
ALTER SCHEMA public OWNER TO seamark;
REVOKE ALL ON SCHEMA public FROM PUBLIC;
GRANT USAGE ON SCHEMA public TO seamark_worker;
SQL
} | ${PSQL:-psql} --no-psqlrc --set ON_ERROR_STOP=1 --username "$POSTGRES_USER" \
    --dbname "$POSTGRES_DB" --set database="$POSTGRES_DB"
