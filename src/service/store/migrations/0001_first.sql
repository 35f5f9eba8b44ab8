-- Times are microseconds since 1970; documents are JSON text; files are named by the SHA-256 of their content.

CREATE TABLE robots (
    id TEXT PRIMARY KEY,
    document TEXT NOT NULL,
    updated_us BIGINT NOT NULL
);

CREATE TABLE jobs (
    id TEXT PRIMARY KEY,
    -- excitation, identification, validation
    kind TEXT NOT NULL,
    -- short or long: each has places of its own on every worker
    class TEXT NOT NULL,
    -- The robot whose tokens see this job
    robot TEXT NOT NULL,
    -- Id of the token that asked for it; empty without one
    token TEXT NOT NULL,
    -- RFC 9218: 0 is the most urgent, 7 the least
    urgency BIGINT NOT NULL,
    -- queued, running, finished, cancelled, failed
    state TEXT NOT NULL,
    -- Of all that determines the result: the same work has the same print
    fingerprint TEXT NOT NULL,
    -- File with the request and all that it names
    input TEXT NOT NULL,
    result TEXT,
    model TEXT,
    outcome TEXT,
    error TEXT,
    progress TEXT,
    step TEXT,
    -- Grows with every change: the id of the event
    sequence BIGINT NOT NULL,
    -- Grows with every claim: a worker whose number is not the row's has lost the job, and what it writes is refused
    lease BIGINT NOT NULL,
    lease_until_us BIGINT,
    worker TEXT,
    attempts BIGINT NOT NULL,
    cancel_requested BIGINT NOT NULL,
    -- Until when other workers may search as well, by the clock of the database; null where they may not
    spread_until_us BIGINT,
    created_us BIGINT NOT NULL,
    started_us BIGINT,
    finished_us BIGINT
);
CREATE INDEX jobs_to_claim ON jobs (state, class, created_us);
CREATE INDEX jobs_of_robot ON jobs (robot, started_us);
CREATE INDEX jobs_by_age ON jobs (created_us);
CREATE INDEX jobs_by_fingerprint ON jobs (fingerprint);

-- Files that a job needs; what no row names is swept.
CREATE TABLE job_files (
    job TEXT NOT NULL REFERENCES jobs (id) ON DELETE CASCADE,
    hash TEXT NOT NULL,
    PRIMARY KEY (job, hash)
);
CREATE INDEX job_files_by_hash ON job_files (hash);

CREATE TABLE idempotency_keys (
    -- Id of the token: keys of different people do not meet
    scope TEXT NOT NULL,
    name TEXT NOT NULL,
    body TEXT NOT NULL,
    job TEXT NOT NULL REFERENCES jobs (id) ON DELETE CASCADE,
    PRIMARY KEY (scope, name)
);
CREATE INDEX idempotency_keys_of_job ON idempotency_keys (job);

CREATE TABLE tokens (
    id TEXT PRIMARY KEY,
    name TEXT NOT NULL,
    -- SHA-256 of the secret, which is 256 random bits: nothing to guess, so nothing to slow down
    hash TEXT NOT NULL UNIQUE,
    role TEXT NOT NULL,
    -- JSON list of names, or ["*"]
    robots TEXT NOT NULL,
    created_us BIGINT NOT NULL,
    revoked_us BIGINT
);

CREATE TABLE audit (
    at_us BIGINT NOT NULL,
    request TEXT NOT NULL,
    token TEXT NOT NULL,
    who TEXT NOT NULL,
    action TEXT NOT NULL,
    robot TEXT NOT NULL,
    target TEXT NOT NULL
);
CREATE INDEX audit_by_time ON audit (at_us);

-- Content of files for the other machines of a PostgreSQL database; empty on SQLite, where the folder is the only place.
CREATE TABLE file_parts (
    hash TEXT NOT NULL,
    part BIGINT NOT NULL,
    content {bytes} NOT NULL,
    written_us BIGINT NOT NULL,
    PRIMARY KEY (hash, part)
);

-- Searches that other workers make for a running design.
CREATE TABLE shares (
    job TEXT NOT NULL REFERENCES jobs (id) ON DELETE CASCADE,
    number BIGINT NOT NULL,
    -- Lease of the job under which the share was taken
    lease BIGINT NOT NULL,
    worker TEXT NOT NULL,
    lease_until_us BIGINT NOT NULL,
    evaluations BIGINT NOT NULL,
    best {real},
    -- Of what was found, once it has ended
    result TEXT,
    PRIMARY KEY (job, number)
);
