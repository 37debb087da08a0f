export function Line({ label, value, state }: { label: string; value: string; state?: 'good' | 'bad' }) {
  return (
    <div class="line">
      <span>{label}</span>
      <span class={`num ${state ?? ''}`}>{value}</span>
    </div>
  );
}
