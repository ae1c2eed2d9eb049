// The two views, as the viewer counts them.

export const SURFACE = 0;
export const FLAT = 1;
