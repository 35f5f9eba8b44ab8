-- What the searches of a running design have found: they go on from each other's, and so does whoever takes the job over.
CREATE TABLE found (
    job TEXT NOT NULL REFERENCES jobs (id) ON DELETE CASCADE,
    -- 0 for the search of the job itself, else that of the share
    number BIGINT NOT NULL,
    -- Of the job when this was written: what an outdated worker writes does not replace what a later one has
    lease BIGINT NOT NULL,
    -- Logarithm of the criterion at the best point
    value {real} NOT NULL,
    -- JSON: the best point of each niche
    points TEXT NOT NULL,
    elapsed_us BIGINT NOT NULL,
    evaluations BIGINT NOT NULL,
    -- Grows with every write
    version BIGINT NOT NULL,
    PRIMARY KEY (job, number)
);
