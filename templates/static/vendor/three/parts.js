// The parts of three.js that the scene of a run uses.
export {
  AdditiveBlending, BoxGeometry, BufferAttribute, BufferGeometry, CapsuleGeometry, Color, ConeGeometry, CylinderGeometry, DirectionalLight,
  DoubleSide, DynamicDrawUsage, Group, HemisphereLight, Line, LineBasicMaterial, LineSegments, LinearMipmapNearestFilter, Matrix4, Mesh,
  MeshBasicMaterial, MeshLambertMaterial, NotEqualStencilFunc, PerspectiveCamera, Points, PointsMaterial, Quaternion, RepeatWrapping,
  ReplaceStencilOp, Scene, SphereGeometry, SRGBColorSpace, TextureLoader, Vector3, WebGLRenderer,
} from "three";
export { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
