/** Walter's arm in space, by three. Loaded when somebody looks at one. */

import {
  AmbientLight,
  Color,
  ConeGeometry,
  CylinderGeometry,
  DirectionalLight,
  GridHelper,
  Mesh,
  MeshLambertMaterial,
  PerspectiveCamera,
  Scene,
  SphereGeometry,
  Vector3,
  WebGLRenderer,
} from "three";
import { armAt, type Point, type Pose } from "../../model/arm";
import type { Palette } from "../../parts/palette";

const FAR = 1.75;
const LOOK_AT = new Vector3(0, 0.36, 0);
const THICK = [0.075, 0.052, 0.042, 0.032];
const UP = new Vector3(0, 1, 0);

export class ArmScene {
  /** Grows when it is looked at from elsewhere. */
  turns = 0;
  private readonly renderer: WebGLRenderer;
  private readonly scene = new Scene();
  private readonly camera = new PerspectiveCamera(38, 1, 0.1, 10);
  private readonly links: Mesh[];
  private readonly joints: Mesh[];
  private readonly fingers: Mesh[];
  private round = 0.7;
  private above = 0.35;

  /** Throws an Error where the browser draws nothing in space. */
  constructor(
    private readonly place: HTMLElement,
    colours: Palette,
  ) {
    this.renderer = new WebGLRenderer({ antialias: true, alpha: true });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.domElement.setAttribute("aria-hidden", "true");
    place.append(this.renderer.domElement);
    const body = new MeshLambertMaterial({ color: new Color(colours.traces[0]) });
    const knot = new MeshLambertMaterial({ color: new Color(colours.soft) });
    const tip = new MeshLambertMaterial({ color: new Color(colours.traces[1]) });
    this.links = THICK.map((thick) => new Mesh(new CylinderGeometry(thick * 0.8, thick, 1, 20), body));
    this.joints = THICK.map((thick) => new Mesh(new SphereGeometry(thick * 1.15, 20, 14), knot));
    this.fingers = [0, 1].map(() => new Mesh(new ConeGeometry(0.016, 1, 10), tip));
    const foot = new Mesh(new CylinderGeometry(0.13, 0.15, 0.04, 32), knot);
    foot.position.y = 0.02;
    const grid = new GridHelper(1.6, 16, new Color(colours.line), new Color(colours.grid));
    const light = new DirectionalLight(0xffffff, 2);
    light.position.set(1, 2, 1.5);
    this.scene.add(...this.links, ...this.joints, ...this.fingers, foot, grid, light, new AmbientLight(0xffffff, 1.4));
    place.addEventListener("pointerdown", this.onDown);
  }

  end(): void {
    this.place.removeEventListener("pointerdown", this.onDown);
    this.scene.traverse((part) => {
      if (part instanceof Mesh) part.geometry.dispose();
    });
    this.renderer.dispose();
    this.renderer.forceContextLoss();
    this.renderer.domElement.remove();
  }

  /** Look from elsewhere. */
  turn(round: number, above: number): void {
    this.round += round;
    this.above = Math.min(Math.max(this.above + above, -0.1), 1.4);
    this.turns++;
  }

  draw(pose: Pose): void {
    const { points, fingers } = armAt(pose);
    const at = points.map(inScene);
    for (const [number, link] of this.links.entries()) stretch(link, at[number]!, at[number + 1]!);
    for (const [number, joint] of this.joints.entries()) joint.position.copy(at[number + 1]!);
    for (const [number, finger] of this.fingers.entries()) stretch(finger, at[4]!, inScene(fingers[number]!));
    const { clientWidth, clientHeight } = this.place;
    this.renderer.setSize(clientWidth, clientHeight);
    this.camera.aspect = clientWidth / Math.max(clientHeight, 1);
    const far = FAR / Math.min(this.camera.aspect, 1);
    this.camera.position.set(
      far * Math.cos(this.above) * Math.sin(this.round),
      LOOK_AT.y + far * Math.sin(this.above),
      far * Math.cos(this.above) * Math.cos(this.round),
    );
    this.camera.lookAt(LOOK_AT);
    this.camera.updateProjectionMatrix();
    this.renderer.render(this.scene, this.camera);
  }

  private readonly onDown = (event: PointerEvent): void => {
    this.place.setPointerCapture(event.pointerId);
    const onMove = (moved: PointerEvent): void => this.turn(-moved.movementX * 0.01, moved.movementY * 0.01);
    const onUp = (): void => {
      this.place.removeEventListener("pointermove", onMove);
      this.place.removeEventListener("pointerup", onUp);
      this.place.removeEventListener("pointercancel", onUp);
    };
    this.place.addEventListener("pointermove", onMove);
    this.place.addEventListener("pointerup", onUp);
    this.place.addEventListener("pointercancel", onUp);
  };
}

/** In the scene y is up. */
function inScene([x, y, z]: Point): Vector3 {
  return new Vector3(x, z, -y);
}

/** Let a body of length 1 go from one point to another. */
function stretch(body: Mesh, from: Vector3, to: Vector3): void {
  const along = to.clone().sub(from);
  body.position.copy(from).addScaledVector(along, 0.5);
  body.scale.set(1, Math.max(along.length(), 1e-4), 1);
  body.quaternion.setFromUnitVectors(UP, along.normalize());
}
