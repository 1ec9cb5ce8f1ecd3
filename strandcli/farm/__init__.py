"""Job files for schedulers: kernels are warmed up once, the scene is simulated once, chunks of frames are drawn side by
side, and the animation is joined."""
