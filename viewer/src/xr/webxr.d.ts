// WebXR Hand Input as browsers have it; the published types lack these.

interface XRFrame {
  fillPoses?(spaces: readonly XRSpace[], baseSpace: XRSpace, transforms: Float32Array): boolean;
  fillJointRadii?(jointSpaces: readonly XRJointSpace[], radii: Float32Array): boolean;
}
