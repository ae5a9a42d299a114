// The picture that the mock shows: a butler robot with one manager, two slaves, a composite and several troubles.
const MANAGER = '/localhost/butler.mgr';
const VISION = `${MANAGER}/vision.mgr`;
const MOTION = `${MANAGER}/motion.mgr`;
const since = Date.now() / 1000 - 4000;

export const managers = [
  { id: MANAGER, name: 'butler', host: 'localhost', pid: 4711, version: '1.4.0', state: 'up', why: '' },
  { id: '/arm-pc/arm.mgr', name: 'arm', host: 'arm-pc', pid: 812, version: '1.4.0', state: 'gone', why: 'The host arm-pc has not answered for 14 s.' },
];
export const processes = [
  { id: MANAGER, name: 'butler', manager: MANAGER, pid: 4711, state: 'up', why: '', is_slave: false },
  { id: VISION, name: 'vision', manager: MANAGER, pid: 4720, state: 'up', why: '', is_slave: true },
  { id: MOTION, name: 'motion', manager: MANAGER, pid: 4731, state: 'up', why: '', is_slave: true },
  { id: '/arm-pc/arm.mgr', name: 'arm', manager: '/arm-pc/arm.mgr', pid: 812, state: 'lost', why: 'The manager has gone.', is_slave: false },
];

const ports = (text) => text.split(' ').filter(Boolean).map((one) => {
  const [direction, name, type = ''] = one.split(':');
  const interfaces = direction === 'service' ? [{ instance: name, type: type || 'MapService', polarity: name.startsWith('use') ? 'Required' : 'Provided' }] : [];
  return { name, direction, type: direction === 'service' ? '' : type, interfaces };
});

function component(name, type, process, look, portText, more = {}) {
  const state = { active: 'Active', inactive: 'Inactive', error: 'Error', created: 'Created' }[look] ?? 'Unknown';
  const manager = process.startsWith(MANAGER) ? MANAGER : process;
  const host = manager === MANAGER ? 'localhost' : 'arm-pc';
  const rate = more.rate ?? 100;
  delete more.rate;
  return {
    id: `/${host}/${name}.rtc`, name, type, type_id: `RTC:rtkit:robots:${type}:1.0`, manager, process, state, look,
    word: state === 'Unknown' ? look : state, remark: '', since, description: `The ${type} of the butler robot.`, composite: '', members: more.members ?? [], is_composite: Boolean(more.members),
    contexts: [{ id: '0', kind: 'PERIODIC', rate_hz: rate, is_running: true, state, owner: `/${host}/${name}.rtc`, participants: [], missed: 0, trouble: '' }],
    ports: ports(portText), active_set: 'default', sets: { default: {} }, widgets: {}, constraints: {},
    properties: { instance_name: name, type_name: type, category: 'robots', vendor: 'rtkit', version: '1.0' }, ...more,
  };
}

export const components = [
  component('Camera0', 'Camera', VISION, 'active', 'out:image:TimedImage out:info:CameraInfo service:control:CameraControl', {
    rate: 30,
    sets: { default: { width: '640', exposure: '0.35', mode: 'auto', filters: 'denoise,sharpen', gain: '4', note: 'front' }, night: { width: '320', exposure: '0.9', mode: 'manual', filters: 'denoise', gain: '12', note: 'front' } },
    widgets: { exposure: 'slider.0.05', mode: 'radio', filters: 'ordered_list', gain: 'spin' },
    constraints: { exposure: '0<=x<=1', mode: '(auto, manual, off)', filters: '(denoise, sharpen, undistort)', gain: '0<=x<=16', width: 'x>0' },
  }),
  component('Detector0', 'Detector', VISION, 'active', 'in:image:TimedImage out:people:TimedPersons', { rate: 10 }),
  component('Laser0', 'Laser', VISION, 'active', 'out:scan:TimedRange', { rate: 40 }),
  component('Odometry0', 'Odometry', MOTION, 'active', 'in:wheels:TimedVelocity out:pose:TimedPose2D'),
  component('Localizer0', 'Localizer', MOTION, 'active', 'in:scan:TimedRange in:odometry:TimedPose2D out:pose:TimedPose2D service:useMap:MapService', { composite: '/localhost/Navigation0.rtc' }),
  component('Planner0', 'Planner', MOTION, 'error', 'in:pose:TimedPose2D in:goal:TimedPose2D out:path:TimedPath', { composite: '/localhost/Navigation0.rtc', remark: 'ValueError: no way around the table (planner.py:88)' }),
  component('Follower0', 'Follower', MOTION, 'inactive', 'in:path:TimedPath in:pose:TimedPose2D out:speed:TimedVelocity', { composite: '/localhost/Navigation0.rtc' }),
  component('Navigation0', 'Navigation', MOTION, 'inactive', '', { members: ['/localhost/Localizer0.rtc', '/localhost/Planner0.rtc', '/localhost/Follower0.rtc'] }),
  component('Base0', 'Base', MOTION, 'active', 'in:speed:TimedVelocity out:wheels:TimedVelocity', { rate: 1000 }),
  component('Map0', 'MapServer', MANAGER, 'active', 'service:map:MapService'),
  component('Butler0', 'Butler', MANAGER, 'active', 'in:people:TimedPersons out:goal:TimedPose2D out:speech:TimedString', { rate: 5 }),
  component('Speaker0', 'Speaker', MANAGER, 'active', 'in:speech:TimedString', { rate: 5 }),
  component('Gripper0', 'Gripper', '/arm-pc/arm.mgr', 'unreachable', 'in:width:TimedDouble', { remark: 'The host does not answer.' }),
  component('Arm0', 'Arm', '/arm-pc/arm.mgr', 'zombie', 'in:goal:TimedPose2D out:joints:TimedDoubleSeq', { remark: 'Its process has ended with signal 9.' }),
];

const wire = (source, target, trouble = '') => {
  const [from, to] = [source, target].map((text) => ({ component: `/${/^(Arm|Gripper)/.test(text) ? 'arm-pc' : 'localhost'}/${text.split('.')[0]}.rtc`, port: text.split('.')[1] }));
  return { id: `${source}-${target}`, name: `${source.replace('.', '_')}_${target.replace('.', '_')}`, source: from, target: to, properties: { 'dataport.subscription_type': 'new', 'dataport.dataflow_type': 'push' }, trouble };
};
export const connectors = [
  wire('Camera0.image', 'Detector0.image'), wire('Detector0.people', 'Butler0.people'), wire('Laser0.scan', 'Localizer0.scan'),
  wire('Base0.wheels', 'Odometry0.wheels'), wire('Odometry0.pose', 'Localizer0.odometry'), wire('Localizer0.pose', 'Planner0.pose'),
  wire('Localizer0.pose', 'Follower0.pose'), wire('Planner0.path', 'Follower0.path', 'Nothing was written for 31 s.'), wire('Follower0.speed', 'Base0.speed'),
  wire('Butler0.goal', 'Planner0.goal'), wire('Butler0.speech', 'Speaker0.speech'), wire('Map0.map', 'Localizer0.useMap'),
  wire('Butler0.goal', 'Arm0.goal', 'Arm0 is a zombie.'),
];

/** Fills the system with so many more components in chains of five, for measurements. */
export function many(system, count) {
  for (let index = 0; index < count; index += 1) {
    const process = `${MANAGER}/s${Math.floor(index / 50)}.mgr`;
    if (index % 50 === 0) system.processes.push({ id: process, name: `s${index / 50}`, manager: MANAGER, pid: 5000 + index, state: 'up', why: '', is_slave: true });
    system.components.push(component(`Filter${index}`, 'Filter', process, index % 97 === 0 ? 'error' : 'active', 'in:in:TimedLong out:out:TimedLong'));
    if (index % 5) system.connectors.push(wire(`Filter${index - 1}.out`, `Filter${index}.in`));
  }
}
