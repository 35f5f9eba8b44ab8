-- Names of the log files of a job, as a JSON list.
ALTER TABLE jobs ADD COLUMN logs TEXT;
