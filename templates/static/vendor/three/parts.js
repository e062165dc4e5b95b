// The parts of three.js that the scene of a run uses.
export {
  BoxGeometry, BufferAttribute, BufferGeometry, CapsuleGeometry, Color, ConeGeometry, CylinderGeometry, DirectionalLight, DoubleSide,
  DynamicDrawUsage, FogExp2, Group, HemisphereLight, Line, LineBasicMaterial, LineSegments, LinearMipmapNearestFilter, Matrix4, Mesh,
  MeshBasicMaterial, MeshLambertMaterial, PerspectiveCamera, Points, PointsMaterial, Quaternion, RepeatWrapping, Scene, ShaderChunk,
  SphereGeometry, SRGBColorSpace, TextureLoader, Vector3, WebGLRenderer,
} from "three";
export { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
