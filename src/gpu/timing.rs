//! Time of a frame on the GPU: the last pass's end less the first pass's begin.

use std::collections::VecDeque;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use super::Gpu;
use super::readback::CALL_BACK;

/// A frame whose time is on its way.
#[derive(Debug)]
struct Pending {
    /// Where the timestamps arrive; without timestamps only the signal that the GPU is done.
    buffer: Option<wgpu::Buffer>,
    ready: Receiver<bool>,
    submitted: Instant,
}

/// Times frames without stalling them: results are handed out when they have arrived.
#[derive(Debug)]
pub struct FrameTimer {
    queries: Option<(wgpu::QuerySet, wgpu::Buffer)>,
    pending: VecDeque<Pending>,
    period_ns: f64,
}

const BYTES: u64 = 2 * size_of::<u64>() as u64;

/// Frames in flight beyond this are not timed: nobody reads the times.
const MOST_PENDING: usize = 8;

impl FrameTimer {
    /// A timer for `gpu`; it falls back to wall time where there are no timestamps.
    pub fn new(gpu: &Gpu) -> Self {
        let queries = gpu.capabilities.timestamps.then(|| {
            let set = gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("frame times"),
                ty: wgpu::QueryType::Timestamp,
                count: 2,
            });
            let resolve = gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("frame times"),
                size: BYTES,
                usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            });
            (set, resolve)
        });
        Self { queries, pending: VecDeque::new(), period_ns: f64::from(gpu.queue.get_timestamp_period()) }
    }

    /// The timestamps for a pass that is the frame's first, its last, or both; none for a pass between.
    pub fn writes(&self, first: bool, last: bool) -> Option<wgpu::RenderPassTimestampWrites<'_>> {
        let (query_set, _) = self.queries.as_ref()?;
        (first || last).then_some(wgpu::RenderPassTimestampWrites {
            query_set,
            beginning_of_pass_write_index: first.then_some(0),
            end_of_pass_write_index: last.then_some(1),
        })
    }

    /// Ends the frame's encoder, submits it and starts waiting for its time.
    pub fn submit(&mut self, gpu: &Gpu, mut encoder: wgpu::CommandEncoder) {
        if self.pending.len() >= MOST_PENDING {
            gpu.queue.submit([encoder.finish()]);
            return;
        }
        let buffer = self.queries.as_ref().map(|(set, resolve)| {
            let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("frame times on their way"),
                size: BYTES,
                usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
                mapped_at_creation: false,
            });
            encoder.resolve_query_set(set, 0..2, resolve, 0);
            encoder.copy_buffer_to_buffer(resolve, 0, &buffer, 0, BYTES);
            buffer
        });
        let submitted = Instant::now();
        gpu.queue.submit([encoder.finish()]);
        let (sender, ready) = channel();
        // A send fails only when the timer is gone, and then nobody waits.
        match &buffer {
            Some(buffer) => buffer.slice(..).map_async(wgpu::MapMode::Read, move |result| {
                let _ = sender.send(result.is_ok());
            }),
            None => gpu.queue.on_submitted_work_done(move || {
                let _ = sender.send(true);
            }),
        }
        self.pending.push_back(Pending { buffer, ready, submitted });
    }

    /// Milliseconds of the oldest frame that has arrived and was not handed out yet. Does not wait.
    pub fn take(&mut self, gpu: &Gpu) -> Option<f64> {
        // A failed poll shows as frames that never arrive; the loss itself is reported by the device.
        let _ = gpu.device.poll(wgpu::PollType::Poll);
        self.take_arrived(Duration::ZERO)
    }

    /// Waits for all frames in flight; milliseconds of the newest.
    pub fn wait(&mut self, gpu: &Gpu) -> Option<f64> {
        let _ = gpu.device.poll(wgpu::PollType::wait_indefinitely());
        let mut newest = None;
        // Another thread's poll may be the one that calls back, a moment after ours has returned.
        while let Some(ms) = self.take_arrived(CALL_BACK) {
            newest = Some(ms);
        }
        newest
    }

    fn take_arrived(&mut self, patience: Duration) -> Option<f64> {
        while let Some(front) = self.pending.front() {
            let arrived = match front.ready.recv_timeout(patience) {
                Ok(arrived) => arrived,
                Err(RecvTimeoutError::Timeout) => return None,
                Err(RecvTimeoutError::Disconnected) => false,
            };
            let frame = self.pending.pop_front()?;
            if arrived {
                return Some(self.milliseconds(&frame));
            }
        }
        None
    }

    fn milliseconds(&self, frame: &Pending) -> f64 {
        let wall = frame.submitted.elapsed().as_secs_f64() * 1e3;
        let Some(buffer) = &frame.buffer else { return wall };
        let ticks = buffer.slice(..).get_mapped_range().ok().map(|bytes| {
            let stamps: Vec<u64> = bytemuck::pod_collect_to_vec(&bytes[..]);
            (stamps[0], stamps[1])
        });
        match ticks {
            Some((begin, end)) if end >= begin => (end - begin) as f64 * self.period_ns * 1e-6,
            _ => wall,
        }
    }
}
