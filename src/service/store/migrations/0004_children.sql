-- How often the process that did the job died of it: not with its server, whose end says nothing about the job.
ALTER TABLE jobs ADD COLUMN child_deaths BIGINT NOT NULL DEFAULT 0;
