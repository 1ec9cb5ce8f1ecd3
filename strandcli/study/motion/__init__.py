"""Where strands are over time: a preset's runs against the limits that finer settings lead to."""
