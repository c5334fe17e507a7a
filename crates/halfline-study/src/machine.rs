//! What a study ran on. What the system does not tell is unknown: only Linux tells all.

use std::fs::read_to_string;

/// One of the processor's caches for data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cache {
    /// 1 for the one next to a core.
    pub level: u32,
    /// Bytes, as one core sees them.
    pub bytes: u64,
}

/// What a machine is made of, as far as it matters for a study.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Machine {
    /// The processor's name.
    pub processor: Option<String>,
    /// Cores, or hardware threads, that the process may use.
    pub cores: usize,
    /// Caches for data, the first level first.
    pub caches: Vec<Cache>,
    /// Bytes of memory that the process may have.
    pub memory_bytes: Option<u64>,
    /// The operating system and the kind of processor.
    pub system: String,
}

impl Machine {
    /// The machine on which the process runs.
    pub fn this() -> Machine {
        Machine {
            processor: processor(),
            cores: std::thread::available_parallelism().map_or(1, Into::into),
            caches: caches(),
            memory_bytes: memory_bytes(),
            system: format!("{}, {}", std::env::consts::OS, std::env::consts::ARCH),
        }
    }

    /// Bytes of a level of its caches.
    pub fn cache_bytes(&self, level: u32) -> Option<f64> {
        let cache = self.caches.iter().find(|cache| cache.level == level)?;
        Some(cache.bytes as f64)
    }
}

fn processor() -> Option<String> {
    let text = read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}

fn caches() -> Vec<Cache> {
    let of_index = |index: u32| -> Option<Cache> {
        let read = |name: &str| {
            let path = format!("/sys/devices/system/cpu/cpu0/cache/index{index}/{name}");
            Some(read_to_string(path).ok()?.trim().to_owned())
        };
        let bytes = bytes_of(&read("size")?)?;
        let level = read("level")?.parse().ok()?;
        (read("type")? != "Instruction").then_some(Cache { level, bytes })
    };
    let mut caches: Vec<Cache> = (0..8).filter_map(of_index).collect();
    caches.sort_by_key(|cache| cache.level);
    caches
}

/// `32K` or `2M` or `512`, in bytes.
fn bytes_of(text: &str) -> Option<u64> {
    let (digits, unit) = match text.strip_suffix('K') {
        Some(digits) => (digits, 1 << 10),
        None => text.strip_suffix('M').map_or((text, 1), |digits| (digits, 1 << 20)),
    };
    Some(digits.parse::<u64>().ok()? * unit)
}

/// The machine's memory, or less if the process may not have all of it.
fn memory_bytes() -> Option<u64> {
    let text = read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("MemTotal:"))?;
    let total = line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()? * 1024;
    let limit = read_to_string("/sys/fs/cgroup/memory.max").ok();
    let limit = limit.and_then(|text| text.trim().parse::<u64>().ok()).unwrap_or(u64::MAX);
    Some(total.min(limit))
}

/// Bytes of memory that the process holds now.
pub fn resident_bytes() -> Option<f64> {
    let status = read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    Some(line.trim().strip_suffix("kB")?.trim().parse::<f64>().ok()? * 1024.0)
}

#[cfg(test)]
mod tests {
    use super::bytes_of;

    #[test]
    fn cache_sizes_are_read() {
        let texts = ["32K", "2M", "512", "1024K", "K", ""];
        let expected = [Some(32 << 10), Some(2 << 20), Some(512), Some(1 << 20), None, None];
        assert_eq!(texts.map(bytes_of), expected);
    }
}
