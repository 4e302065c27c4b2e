//! The hammer test in time: pulses of finite width, the structure's response, converter, noise, windows,
//! averages, H1 and coherence.

pub mod block;
pub mod fft;
pub mod pulse;
pub mod series;
pub mod setting;
