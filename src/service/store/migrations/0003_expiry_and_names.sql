-- From when on a token is refused; null for never.
ALTER TABLE tokens ADD COLUMN expires_us BIGINT;
-- What people call a job, and what they write about it.
ALTER TABLE jobs ADD COLUMN name TEXT;
ALTER TABLE jobs ADD COLUMN note TEXT;
