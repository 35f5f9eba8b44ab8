// What the pages use of three.js, as one file.
export {
  AmbientLight, BoxGeometry, BufferGeometry, CanvasTexture, CapsuleGeometry, CatmullRomCurve3, ConeGeometry, CylinderGeometry, DirectionalLight, DoubleSide, EdgesGeometry, Float32BufferAttribute, Group, Line,
  LineBasicMaterial, LineSegments, Matrix4, Mesh, MeshLambertMaterial, OrthographicCamera, PlaneGeometry, Quaternion, Scene, SphereGeometry, Sprite, SpriteMaterial, Texture, TubeGeometry, Vector3, WebGLRenderer,
} from 'three';
export { GLTFLoader } from 'three/examples/jsm/loaders/GLTFLoader.js';
export { STLLoader } from 'three/examples/jsm/loaders/STLLoader.js';
export { SVGRenderer } from 'three/examples/jsm/renderers/SVGRenderer.js';
