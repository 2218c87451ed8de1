//! Processor time and memory that a part of a benchmark took.

/// Processor time of this process so far, user and system, all threads (Linux; 0 elsewhere): what a
/// busy machine leaves true.
pub(super) fn processor_s() -> f64 {
    let Ok(text) = std::fs::read_to_string("/proc/self/stat") else {
        return 0.0;
    };
    // The name in the second field may hold spaces; user and system time are the 12th and 13th
    // behind it, in ticks of 10 ms.
    let after = text.rsplit(") ").next().unwrap_or("");
    let fields = after.split(' ').skip(11).take(2);
    fields.filter_map(|ticks| ticks.parse::<f64>().ok()).sum::<f64>() / 100.0
}

/// Forgets the highest memory so far and tells what is taken now, MB (Linux).
pub(super) fn peak_from_here_mb() -> Option<f64> {
    std::fs::write("/proc/self/clear_refs", "5").ok()?;
    peak_mb()
}

/// The most resident memory since then, MB.
pub(super) fn peak_mb() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    let kb: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kb / 1e3)
}

/// Anonymous resident memory of this process in MB (Linux): file pages of a mapped log are the
/// system's to take back.
pub(super) fn anonymous_mb() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("RssAnon:"))?;
    line.split_whitespace().nth(1)?.parse::<f64>().ok().map(|kb| kb / 1e3)
}
