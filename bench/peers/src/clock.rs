//! What is called time. On one thread it is what the process has spent of the processor, which
//! nothing else on the machine lengthens but by the caches; on several it is that of the wall.

use std::time::Duration;

use rustix::time::{ClockId, clock_gettime};

/// Measures all tools alike.
#[derive(Clone, Copy)]
pub enum Clock {
    Processor,
    Wall,
}

impl Clock {
    pub fn of(threads: usize) -> Clock {
        if threads == 1 { Clock::Processor } else { Clock::Wall }
    }

    pub fn name(self) -> &'static str {
        match self {
            Clock::Processor => "process CPU time",
            Clock::Wall => "wall time",
        }
    }

    fn now(self) -> Duration {
        let now = clock_gettime(match self {
            Clock::Processor => ClockId::ProcessCPUTime,
            Clock::Wall => ClockId::Monotonic,
        });
        Duration::try_from(now).expect("clocks count from their beginning")
    }

    /// How long the work takes, and what it gives.
    pub fn time<T>(self, work: impl FnOnce() -> T) -> (f64, T) {
        let start = self.now();
        let answer = work();
        ((self.now() - start).as_secs_f64(), answer)
    }
}
