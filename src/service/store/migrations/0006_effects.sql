-- The lab's catalogue of own effects; documents are JSON text.
CREATE TABLE effects (
    name TEXT PRIMARY KEY,
    document TEXT NOT NULL,
    updated_us BIGINT NOT NULL
);
