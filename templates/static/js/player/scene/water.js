// The water between the vehicle's camera and what it looks at: L = (J - B) exp(-c R) + B, in display values and
// per colour, as sim/camera/water.py computes the camera's pictures; and the light, with the vehicle's lamp.
//
// R is measured from the vehicle's camera in every view. So seabed and target have the same contrast here as
// in the camera's picture, from wherever one looks; vehicles and arrows are drawn without water, for the scene
// also has to show where the vehicle is when its camera sees nothing.
/**
 * @import { Material, Matrix4, Object3D } from "three"
 * @import { LightData, Triple, WaterData } from "../../server_data.d.ts"
 */
import { Color, SRGBColorSpace, Vector3 } from "../../../vendor/three/three.min.js";

/** @type {Pick<WaterData, "law" | "attenuation">} */
const CLEAR = { law: "beer", attenuation: [0.02, 0.02, 0.02] }; // [1/m] with turbidity switched off
const DAYLIGHT = { level: 1, lamp: 0, cone: 1, forward: 0 };

const VERTEX = "vWater = (modelMatrix * vec4(transformed, 1.0)).xyz - waterEye;";
const UNIFORMS = `
varying vec3 vWater;
uniform vec3 waterAttenuation, waterVeil, waterAxis, lampOffset;
uniform float daylight, lamp, lampCone;`;
const LAMP = `
float waterDepth = dot(vWater, waterAxis);
float illuminance = daylight;
if (waterDepth > 0.02) {
  vec3 fromLamp = vWater - lampOffset;
  float ahead = dot(fromLamp, waterAxis), square = dot(fromLamp, fromLamp);
  float inCone = 1.0 / (1.0 + (square - ahead * ahead) / (ahead * ahead) * lampCone);
  illuminance += lamp * inCone / square * exp(-waterAttenuation.g * sqrt(square)) * waterDepth / length(vWater);
}
gl_FragColor.rgb *= illuminance;`;
const DAYLIGHT_ALONE = "gl_FragColor.rgb *= daylight;";
const LAWS = {
  beer: "vec3 opticalDepth = waterAttenuation * length(vWater);",
  uwsim: "vec3 opticalDepth = waterAttenuation * max(dot(vWater, waterAxis), 0.0); opticalDepth *= opticalDepth;",
};
const MIX = "gl_FragColor.rgb = mix(waterVeil, gl_FragColor.rgb, exp(-opticalDepth));";

export class Water {
  constructor() {
    this.colour = new Color(); // of water without end
    this.axis = new Vector3(0, -1, 0);
    this.eye = new Vector3();
    this.lamp = new Vector3(); // from the eye
    this.attenuation = new Vector3();
    this.veil = new Vector3();
    this.turbid = true;
    /** @type {Material[]} */
    this.materials = [];
    /** @type {WaterData | null} */
    this.water = null;
    this.light = DAYLIGHT;
    /** @type {{law: WaterData["law"], lit: boolean}} */
    this.kind = { law: "beer", lit: false }; // what the shaders are compiled for
    this.uniforms = {
      waterEye: { value: this.eye },
      waterAxis: { value: this.axis },
      lampOffset: { value: this.lamp },
      waterAttenuation: { value: this.attenuation },
      waterVeil: { value: this.veil },
      daylight: { value: 1 },
      lamp: { value: 0 },
      lampCone: { value: 1 },
    };
  }

  /**
   * Returns the material, which is now seen through the water.
   * @template {Material} M
   * @param {M} material
   * @returns {M}
   */
  seen(material) {
    this.materials.push(material);
    material.customProgramCacheKey = () => `${this.kind.law} ${this.kind.lit}`;
    material.onBeforeCompile = (shader) => {
      const { law, lit } = this.kind;
      Object.assign(shader.uniforms, this.uniforms);
      shader.vertexShader = shader.vertexShader
        .replace("#include <fog_pars_vertex>", "varying vec3 vWater;\nuniform vec3 waterEye;")
        .replace("#include <fog_vertex>", VERTEX);
      shader.fragmentShader = shader.fragmentShader
        .replace("#include <fog_pars_fragment>", UNIFORMS)
        .replace("#include <fog_fragment>", `${lit ? LAMP : DAYLIGHT_ALONE}\n${LAWS[law]}\n${MIX}`);
    };
    return material;
  }

  /**
   * water, light: of scene.json
   * @param {WaterData} water
   * @param {LightData} light
   */
  set(water, light) {
    this.water = water;
    this.light = light;
    const { law, attenuation } = this.turbid ? water : CLEAR;
    const { level, lamp, cone } = this.turbid ? light : DAYLIGHT;
    this.attenuation.fromArray(attenuation);
    this.veil.fromArray(water.veil).multiplyScalar(level);
    const [red, green, blue] = water.veil;
    this.colour.setRGB(red * level, green * level, blue * level, SRGBColorSpace);
    const { uniforms } = this;
    uniforms.daylight.value = level;
    uniforms.lamp.value = lamp;
    uniforms.lampCone.value = 1 / Math.tan(cone) ** 2;
    this.compileFor(law, lamp > 0);
  }

  /**
   * @param {WaterData["law"]} law
   * @param {boolean} lit
   */
  compileFor(law, lit) {
    if (law === this.kind.law && lit === this.kind.lit) return;
    this.kind = { law, lit };
    for (const material of this.materials) material.needsUpdate = true;
  }

  // No material is seen through it any more.
  clear() {
    this.materials = [];
  }

  /** @param {boolean} turbid */
  setTurbid(turbid) {
    this.turbid = turbid;
    if (this.water) this.set(this.water, this.light);
  }

  /**
   * vehicle: its group in the world; mount: of the camera in the body frame [m], which looks down
   * @param {Object3D} vehicle
   * @param {Triple} mount
   * @param {Matrix4} toScreen
   */
  lookFrom(vehicle, mount, toScreen) {
    /** @type {(x: number, y: number, z: number) => Vector3} */
    const place = (x, y, z) => new Vector3(x, y, z).applyMatrix4(vehicle.matrix).applyMatrix4(toScreen);
    const [x, y, z] = mount;
    this.eye.copy(place(x, y, z));
    this.axis.copy(place(x, y, z + 1)).sub(this.eye);
    this.lamp.copy(place(x + this.light.forward, y, z)).sub(this.eye);
  }
}
